#include "plcopen/input_text.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <new>

#include "core/text.h"
#include "plcopen/encoding.h"

namespace plc::plcopen {

namespace {

/// libxml2 counts bytes in an int.
constexpr std::size_t kMostBytes = std::numeric_limits<int>::max() - 16;

core::SourceRef place_in(std::string_view text, std::size_t offset, std::uint16_t file) {
  const Place place = PlaceFinder(text).at(offset);
  return {.line = place.line, .column = place.column, .file = file};
}

bool is_name_start(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == ':' ||
         static_cast<unsigned char>(c) >= 0x80;
}

/// Attributes of the start tag at the begin of `text`, counted up to `limit` + 1.
std::size_t count_attributes(std::string_view text, std::size_t limit) {
  std::size_t count = 0;
  std::size_t i = 1;
  while (count <= limit) {
    i = text.find_first_of("\"'>", i);
    if (i == std::string_view::npos || text[i] == '>') break;
    ++count;
    i = text.find(text[i], i + 1);
    if (i == std::string_view::npos) break;
    ++i;
  }
  return count;
}

/// True when the DOCTYPE at `open` has an internal subset. Only quoted texts may contain a '<'.
bool has_internal_subset(std::string_view text, std::size_t open) {
  std::size_t i = open + 1;
  while ((i = text.find_first_of("\"'<>[", i)) != std::string_view::npos) {
    if (text[i] == '[') return true;
    if (text[i] == '>' || text[i] == '<') return false;
    i = text.find(text[i], i + 1);
    if (i == std::string_view::npos) return false;
    ++i;
  }
  return false;
}

/// CR CR LF, as OpenPLC Editor writes it on Windows, is one line end. XML would make two of it.
void blank_doubled_returns(char* text, std::size_t size) {
  std::size_t i = 0;
  while (i + 2 < size) {
    const void* const found = std::memchr(text + i, '\r', size - i - 2);
    if (found == nullptr) return;
    i = static_cast<std::size_t>(static_cast<const char*>(found) - text);
    std::size_t end = i;
    while (end < size && text[end] == '\r') ++end;
    if (end < size && text[end] == '\n') std::memset(text + i, ' ', end - i - 1);
    i = end;
  }
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace

Place PlaceFinder::at(std::size_t offset) {
  offset = std::min(offset, text_.size());
  if (offset < marked_offset_) return PlaceFinder(text_).at(offset);
  if (offset < offset_) {
    offset_ = marked_offset_;
    place_ = marked_;
  }
  const char* from = text_.data() + offset_;
  const char* const end = text_.data() + offset;
  while (from != end) {
    const void* newline = std::memchr(from, '\n', static_cast<std::size_t>(end - from));
    if (newline == nullptr) break;
    ++place_.line;
    place_.column = 1;
    from = static_cast<const char*>(newline) + 1;
  }
  std::uint32_t characters = 0;
  for (; from != end; ++from) characters += (static_cast<unsigned char>(*from) & 0xC0u) != 0x80u ? 1u : 0u;
  place_.column += characters;
  offset_ = offset;
  return place_;
}

Place PlaceFinder::mark(std::size_t offset) {
  marked_ = at(offset);
  marked_offset_ = offset_;
  return marked_;
}

bool InputText::allocate(std::size_t size) {
  constexpr std::size_t kPadding = 16;
  bytes_.reset(new (std::nothrow) char[size + kPadding]);
  if (bytes_ == nullptr) return false;
  std::memset(bytes_.get() + size, 0, kPadding);
  size_ = size;
  return true;
}

std::unique_ptr<InputText> InputText::from_file(const std::string& path, std::uint16_t file,
                                                core::Diagnostics& diagnostics, const ReadLimits& limits) {
  const core::SourceRef at{.file = file};
  const auto refuse = [&](const std::string& why) {
    diagnostics.report(core::Code::P1001, at, {}, why, "give the path of a readable PLCopen XML file");
    return nullptr;
  };
  // O_NONBLOCK: a FIFO given by mistake must not hang the program.
  const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (descriptor.get() < 0) return refuse(fmt::format("\"{}\" cannot be opened: {}", path, std::strerror(errno)));
  struct stat status {};
  if (::fstat(descriptor.get(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return refuse(fmt::format("\"{}\" is not a regular file", path));
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > limits.max_bytes) {
    diagnostics.report(core::Code::P1006, at, {},
                       fmt::format("file has {} bytes, the limit is {}", size, limits.max_bytes));
    return nullptr;
  }
  std::unique_ptr<InputText> input(new InputText);
  if (!input->allocate(size)) return refuse(fmt::format("no memory for {} bytes", size));
  // Read, not mapped: a file that shrinks while it is mapped kills the process.
  std::size_t done = 0;
  while (done < size) {
    const ssize_t got = ::read(descriptor.get(), input->bytes_.get() + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return refuse(fmt::format("\"{}\" cannot be read: {}", path, std::strerror(errno)));
    if (got == 0) return refuse(fmt::format("\"{}\" became shorter while it was read", path));
    done += static_cast<std::size_t>(got);
  }
  if (!input->normalise(file, diagnostics, limits)) return nullptr;
  return input;
}

std::unique_ptr<InputText> InputText::from_memory(std::string_view bytes, std::uint16_t file,
                                                  core::Diagnostics& diagnostics, const ReadLimits& limits) {
  const core::SourceRef at{.file = file};
  if (bytes.size() > limits.max_bytes) {
    diagnostics.report(core::Code::P1006, at, {},
                       fmt::format("file has {} bytes, the limit is {}", bytes.size(), limits.max_bytes));
    return nullptr;
  }
  std::unique_ptr<InputText> input(new InputText);
  if (!input->allocate(bytes.size())) {
    diagnostics.report(core::Code::P1001, at, {}, fmt::format("no memory for {} bytes", bytes.size()));
    return nullptr;
  }
  if (!bytes.empty()) std::memcpy(input->bytes_.get(), bytes.data(), bytes.size());
  if (!input->normalise(file, diagnostics, limits)) return nullptr;
  return input;
}

bool InputText::normalise(std::uint16_t file, core::Diagnostics& diagnostics, const ReadLimits& limits) {
  const Encoding encoding = detect_encoding({bytes_.get(), size_});
  if (encoding.kind == Encoding::Kind::kUnknown) {
    diagnostics.report(core::Code::P1014, {.line = 1, .column = 1, .file = file}, {},
                       fmt::format("encoding \"{}\" is not supported", encoding.name),
                       "export or convert the file as UTF-8");
    return false;
  }
  if (encoding.kind != Encoding::Kind::kUtf8) {
    const std::unique_ptr<char[]> raw = std::move(bytes_);
    const std::string_view from{raw.get() + encoding.bom, size_ - encoding.bom};
    if (!allocate(utf8_size(from, encoding.kind))) {
      diagnostics.report(core::Code::P1001, {.file = file}, {}, "no memory for the text as UTF-8");
      return false;
    }
    to_utf8(from, encoding.kind, bytes_.get());
  } else {
    begin_ = encoding.bom;
  }
  blank_doubled_returns(bytes_.get() + begin_, size_ - begin_);
  const std::string_view all = text();
  if (all.size() > kMostBytes) {
    diagnostics.report(core::Code::P1006, {.file = file}, {},
                       fmt::format("text has {} bytes, the XML parser takes {}", all.size(), kMostBytes));
    return false;
  }
  const std::size_t zero = all.find('\0');
  if (zero != std::string_view::npos) {
    diagnostics.report(core::Code::P1002, place_in(all, zero, file), {}, "zero byte in the file");
    return false;
  }
  // Anything else at the start would make the XML parser guess an encoding and positions would no longer be ours.
  const std::size_t first = all.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || all[first] != '<') {
    diagnostics.report(core::Code::P1002, place_in(all, first == std::string_view::npos ? 0 : first, file), {},
                       all.empty() ? "file is empty" : "file does not start with an XML element",
                       "give a PLCopen XML export, not a project file of the tool");
    return false;
  }
  return check_markup(file, diagnostics, limits);
}

// libxml2 compares the attributes of a tag pairwise and expands what a DTD declares: both are bounded here, before it
// sees the text.
bool InputText::check_markup(std::uint16_t file, core::Diagnostics& diagnostics, const ReadLimits& limits) const {
  const std::string_view all = text();
  std::size_t i = all.find('<');
  while (i != std::string_view::npos) {
    const std::string_view rest = all.substr(i);
    std::string_view closing;
    if (rest.starts_with("<!--"))
      closing = "-->";
    else if (rest.starts_with("<![CDATA["))
      closing = "]]>";
    else if (rest.starts_with("<?"))
      closing = "?>";
    if (!closing.empty()) {
      const std::size_t end = all.find(closing, i + 2);
      if (end == std::string_view::npos) return true;
      i = all.find('<', end);
      continue;
    }
    if (rest.starts_with("<!DOCTYPE") && has_internal_subset(all, i)) {
      diagnostics.report(core::Code::P1005, place_in(all, i, file), {}, "DOCTYPE with declarations of its own",
                         "remove the DOCTYPE; PLCopen XML needs none");
      return false;
    }
    const std::size_t next = all.find('<', i + 1);
    const std::size_t length = (next == std::string_view::npos ? all.size() : next) - i;
    // An attribute takes at least four bytes, so that nearly every tag is short enough to need no count.
    if (length / 4 > limits.max_attributes && is_name_start(all[i + 1]) &&
        count_attributes(rest.substr(0, length), limits.max_attributes) > limits.max_attributes) {
      diagnostics.report(core::Code::P1006, place_in(all, i, file), {},
                         fmt::format("element has more than {} attributes", limits.max_attributes));
      return false;
    }
    i = next;
  }
  return true;
}

}  // namespace plc::plcopen
