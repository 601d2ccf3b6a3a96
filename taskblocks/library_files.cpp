#include "taskblocks/library_files.h"

#include <dlfcn.h>
#include <elf.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <string_view>

#include "core/floating_point.h"

namespace plc::taskblocks {
namespace {

using core::Problem;

/// Whether somebody else than root and this user may change it. Access lists count: their mask shows as the bits of the
/// group.
std::string writable_by_others(const struct stat& status) {
  if (status.st_uid != 0 && status.st_uid != ::geteuid()) {
    return fmt::format("belongs to user {}, neither root nor the one who runs this", status.st_uid);
  }
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return fmt::format("may be written by {}", (status.st_mode & S_IWOTH) != 0 ? "everybody" : "its group");
  }
  return {};
}

std::string parent_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return path.substr(0, slash == 0 ? 1 : slash);
}

Problem refuse(const std::string& path, const std::string& what, const std::string& why) {
  return library_refused(path, what + " " + why,
                         "code that controls the plant must come from root or from the user of the service: "
                         "chown root it, and chmod go-w it");
}

/// The folder and those above it, from the first that exists on. `path`: the library, for messages.
std::optional<Problem> check_folders(const std::string& path, std::string folder) {
  struct stat status {};
  for (; folder != "/" && ::stat(folder.c_str(), &status) != 0; folder = parent_of(folder)) {
    if (errno != ENOENT && errno != ENOTDIR) return library_refused(path, folder + ": " + std::strerror(errno), {});
  }
  for (bool first = true;; first = false) {
    if (::stat(folder.c_str(), &status) != 0) return library_refused(path, folder + ": " + std::strerror(errno), {});
    // In a folder like /tmp everybody may add entries, and nobody may replace those of others. That is good enough
    // above, but not where the system looks for libraries.
    if (!first && (status.st_mode & S_ISVTX) != 0) status.st_mode &= ~static_cast<mode_t>(S_IWGRP | S_IWOTH);
    if (const std::string why = writable_by_others(status); !why.empty())
      return refuse(path, "the folder " + folder, why);
    if (folder == "/") return std::nullopt;
    folder = parent_of(folder);
  }
}

/// Code is loaded from places only where nobody else can have put it. `file` has no links in it.
std::optional<Problem> check_place(const std::string& path, const std::string& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return library_refused(path, std::strerror(errno), {});
  if (!S_ISREG(status.st_mode)) return library_refused(path, "it is no file", "give the path of a shared object");
  if (const std::string why = writable_by_others(status); !why.empty()) {
    return refuse(path, file == path ? "it" : "what it needs, " + file + ",", why);
  }
  return check_folders(path, parent_of(file));
}

std::string read_bytes(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What a shared object tells the loader about others. Empty for what is none.
class Needs {
 public:
  explicit Needs(const std::string& bytes) : bytes_(bytes) {
    Elf64_Ehdr head;
    if (!get(0, head) || std::memcmp(head.e_ident, ELFMAG, SELFMAG) != 0 || head.e_ident[EI_CLASS] != ELFCLASS64 ||
        head.e_phentsize != sizeof(Elf64_Phdr)) {
      return;
    }
    for (std::size_t i = 0; i < head.e_phnum; ++i) {
      Elf64_Phdr part;
      if (!get(head.e_phoff + i * sizeof part, part)) return;
      parts_.push_back(part);
    }
    for (const Elf64_Phdr& part : parts_) {
      if (part.p_type == PT_DYNAMIC) read_dynamic(part);
    }
  }
  std::vector<std::string> libraries;
  std::vector<std::string> folders;  ///< as they are written, RUNPATH, or RPATH without one
  std::string name;                  ///< SONAME

 private:
  template <class T>
  bool get(std::uint64_t at, T& to) const {
    if (at > bytes_.size() || bytes_.size() - at < sizeof to) return false;
    std::memcpy(&to, bytes_.data() + at, sizeof to);
    return true;
  }
  [[nodiscard]] std::uint64_t place_of(std::uint64_t address) const {
    for (const Elf64_Phdr& part : parts_) {
      if (part.p_type == PT_LOAD && address >= part.p_vaddr && address - part.p_vaddr < part.p_filesz) {
        return address - part.p_vaddr + part.p_offset;
      }
    }
    return bytes_.size();
  }
  void read_dynamic(const Elf64_Phdr& part) {
    std::vector<Elf64_Dyn> entries;
    Elf64_Dyn entry;
    for (std::uint64_t at = part.p_offset; get(at, entry) && entry.d_tag != DT_NULL; at += sizeof entry) {
      entries.push_back(entry);
    }
    const auto first = [&](std::int64_t tag) {
      return std::find_if(entries.begin(), entries.end(), [&](const Elf64_Dyn& e) { return e.d_tag == tag; });
    };
    const auto table = first(DT_STRTAB);
    if (table == entries.end()) return;
    const std::uint64_t texts = place_of(table->d_un.d_ptr);
    const auto text = [&](const Elf64_Dyn& e) -> std::string {
      if (texts >= bytes_.size() || e.d_un.d_val >= bytes_.size() - texts) return {};
      const std::size_t begin = texts + e.d_un.d_val;
      return bytes_.substr(begin, std::min(bytes_.find('\0', begin), bytes_.size()) - begin);
    };
    for (const Elf64_Dyn& e : entries) {
      if (e.d_tag == DT_NEEDED) libraries.push_back(text(e));
      if (e.d_tag == DT_SONAME) name = text(e);
    }
    auto path = first(DT_RUNPATH);
    if (path == entries.end()) path = first(DT_RPATH);
    if (path == entries.end()) return;
    const std::string list = text(*path);
    for (std::size_t begin = 0; begin <= list.size();) {
      const std::size_t end = std::min(list.find(':', begin), list.size());
      folders.push_back(list.substr(begin, end - begin));
      begin = end + 1;
    }
  }

  const std::string& bytes_;
  std::vector<Elf64_Phdr> parts_;
};

class Collector {
 public:
  explicit Collector(const std::string& library) : library_(library) {}

  std::optional<Problem> add(const std::string& file, std::vector<std::string> inherited = {}) {
    if (std::find(begun_.begin(), begun_.end(), file) != begun_.end()) return std::nullopt;
    begun_.push_back(file);
    if (auto problem = check_place(library_, file)) return problem;
    const std::string bytes = read_bytes(file);
    const Needs needs(bytes);
    for (const std::string& written : needs.folders) {
      const std::string folder = expanded(written, file);
      if (folder.empty()) {
        return library_refused(library_, fmt::format("{} looks for libraries in \"{}\"", file, written),
                               "a RUNPATH is an absolute folder, or begins with $ORIGIN");
      }
      if (auto problem = check_folders(library_, folder)) return problem;
      inherited.push_back(folder);
    }
    for (const std::string& needed : needs.libraries) {
      for (const std::string& folder : inherited) {
        const bool is_path = needed.find('/') != std::string::npos;
        const std::string candidate = is_path ? needed : fmt::format("{}/{}", folder, needed);
        const std::unique_ptr<char, decltype(&std::free)> real(::realpath(candidate.c_str(), nullptr), &std::free);
        if (real == nullptr) continue;
        if (auto problem = add(real.get(), inherited)) return problem;
        break;
      }
    }
    files.push_back(file);
    return std::nullopt;
  }
  std::vector<std::string> files;

 private:
  /// Absolute, or empty.
  static std::string expanded(std::string folder, const std::string& file) {
    for (const std::string_view origin : {"${ORIGIN}", "$ORIGIN"}) {
      if (folder.starts_with(origin)) folder.replace(0, origin.size(), parent_of(file));
    }
    return folder.starts_with('/') && folder.find('$') == std::string::npos ? folder : std::string();
  }

  const std::string& library_;
  std::vector<std::string> begun_;
};

/// The path of a copy in memory, which stays as long as the process; empty when there is none to be had.
std::string copy_of(const std::string& file) {
  const std::string bytes = read_bytes(file);
  const int copy = ::memfd_create(file.substr(file.rfind('/') + 1).c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (copy < 0) return {};
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = ::write(copy, bytes.data() + done, bytes.size() - done);
    if (written <= 0) return ::close(copy), std::string();
    done += static_cast<std::size_t>(written);
  }
  ::fcntl(copy, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW);
  // By number: a debugger finds it, too. The descriptor stays open, so that no other copy gets this name.
  return fmt::format("/proc/{}/fd/{}", ::getpid(), copy);
}

}  // namespace

core::Problem library_refused(const std::string& path, const std::string& why, std::string help) {
  return {core::Code::P7801, path + ": " + why, std::move(help)};
}

core::Result<std::vector<std::string>> check_library_files(const std::string& path) {
  Collector collector(path);
  if (auto problem = collector.add(path)) return std::move(*problem);
  return std::move(collector.files);
}

void* open_library(const std::vector<std::string>& files, std::string& why) {
  const core::KeptFloatingPointMode kept;
  void* opened = nullptr;
  for (const std::string& file : files) {
    // What was opened before is found by its SONAME.
    const std::string copy = copy_of(file);
    opened = copy.empty() ? nullptr : ::dlopen(copy.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (opened == nullptr) opened = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (opened != nullptr) continue;
    // It names the file itself, mostly.
    why = ::dlerror();
    if (why.rfind(file + ": ", 0) == 0) why.erase(0, file.size() + 2);
    return nullptr;
  }
  return opened;
}

}  // namespace plc::taskblocks
