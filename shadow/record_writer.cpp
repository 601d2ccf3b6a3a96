#include "shadow/record_writer.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace plc::shadow {
namespace {

core::Problem cannot_write(const std::string& path, int error) {
  return {core::Code::P7631, path + ": " + std::system_category().message(error),
          "the recording goes on in memory; name another file, or make room"};
}

}  // namespace

core::Result<std::unique_ptr<RecordWriter>> RecordWriter::open(const std::string& path,
                                                               std::span<const std::byte> begin) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (descriptor < 0) return cannot_write(path, errno);
  std::unique_ptr<RecordWriter> made(new RecordWriter(descriptor, path));
  if (made->write(begin)) return made;
  // Nobody can do anything with it. What is a device stays.
  struct stat status {};
  if (::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) ::unlink(path.c_str());
  return *made->problem();
}

RecordWriter::~RecordWriter() { ::close(descriptor_); }

bool RecordWriter::write(std::span<const std::byte> block) {
  error_ = 0;
  for (std::size_t done = 0; done < block.size();) {
    const ssize_t count =
        ::pwrite(descriptor_, block.data() + done, block.size() - done, static_cast<off_t>(bytes_ + done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      error_ = count < 0 ? errno : ENOSPC;
      // What was written of the block goes. Where that fails, the next one is written over it.
      [[maybe_unused]] const int cut = ::ftruncate(descriptor_, static_cast<off_t>(bytes_));
      return false;
    }
    done += static_cast<std::size_t>(count);
  }
  bytes_ += block.size();
  return true;
}

std::optional<core::Problem> RecordWriter::problem() const {
  if (error_ == 0) return {};
  return cannot_write(path_, error_);
}

}  // namespace plc::shadow
