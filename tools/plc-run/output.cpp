#include "tools/plc-run/output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <iostream>
#include <utility>

#include "tools/command_line.h"

namespace plc::tools {
namespace {

/// A terminal that says it can be written to takes at least this.
constexpr std::size_t kTerminalPiece = 256;
constexpr int kWaitMs = 50;

int open_standard_descriptors() {
  for (int fd = 0; fd <= STDERR_FILENO; ++fd) {
    // The lowest number that is free is this one.
    if (::fcntl(fd, F_GETFD) < 0 && errno == EBADF) static_cast<void>(::open("/dev/null", O_RDWR));
  }
  return STDOUT_FILENO;
}

}  // namespace

PatientBuffer::PatientBuffer(int descriptor)
    : descriptor_(descriptor), terminal_(::isatty(descriptor) == 1), piece_(terminal_ ? kTerminalPiece : PIPE_BUF) {}

void PatientBuffer::wait_again(std::function<bool()> give_up) {
  waits_ = true;
  give_up_ = std::move(give_up);
}

/// As much as can be written without waiting.
PatientBuffer::Written PatientBuffer::write_some() {
  std::size_t done = 0;
  Written result = Written::kAll;
  while (done < waiting_.size()) {
    pollfd out{descriptor_, POLLOUT, 0};
    if (::poll(&out, 1, 0) != 1 || (out.revents & (POLLOUT | POLLERR | POLLNVAL)) == 0) {
      result = Written::kBlocked;
      break;
    }
    const ssize_t written = ::write(descriptor_, waiting_.data() + done, std::min(waiting_.size() - done, piece_));
    if (written > 0) {
      done += static_cast<std::size_t>(written);
    } else if (errno != EINTR) {
      result = errno == EAGAIN                    ? Written::kBlocked
               : errno == EPIPE || errno == EBADF ? Written::kNobody
                                                  : Written::kRefused;
      break;
    }
  }
  waiting_.erase(0, result == Written::kNobody ? waiting_.size() : done);
  if (!waiting_.empty() || lost_lines_ == 0) return result;
  const std::uint64_t lost = std::exchange(lost_lines_, 0);
  if (result == Written::kAll)
    add(fmt::format("plc-run: {} lines are lost: they could not be written in time\n", lost));
  return waiting_.empty() ? result : Written::kBlocked;
}

int PatientBuffer::sync() {
  for (;;) {
    const Written written = write_some();
    if (written == Written::kAll || written == Written::kNobody || !waits_) return 0;
    // A disk that is full stays full for as long as somebody waits for it.
    refused_ = refused_ || written == Written::kRefused;
    if (written == Written::kRefused || (give_up_ && give_up_())) return waiting_.clear(), 0;
    pollfd out{descriptor_, POLLOUT, 0};
    ::poll(&out, 1, kWaitMs);
  }
}

void PatientBuffer::add(std::string_view text) {
  if (waiting_.size() + text.size() > kMostWaiting) sync();
  if (!waits_ && waiting_.size() + text.size() > kMostWaiting) {
    lost_lines_ += static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n'));
    return;
  }
  waiting_ += text;
}

PatientBuffer::int_type PatientBuffer::overflow(int_type character) {
  if (!traits_type::eq_int_type(character, traits_type::eof())) {
    const char one = traits_type::to_char_type(character);
    ++texts_;
    add({&one, 1});
  }
  return traits_type::not_eof(character);
}

std::streamsize PatientBuffer::xsputn(const char* text, std::streamsize count) {
  ++texts_;
  add({text, static_cast<std::size_t>(count)});
  return count;
}

void PatientBuffer::print_or_drop(std::string_view text) {
  if (write_some() != Written::kAll) return;
  waiting_ = text;
  write_some();
  waiting_.clear();
}

Output::Output()
    : out_(open_standard_descriptors()),
      err_(STDERR_FILENO),
      out_before_(std::cout.rdbuf(&out_)),
      err_before_(std::cerr.rdbuf(&err_)) {}

Output::~Output() {
  flush();
  std::cout.rdbuf(out_before_);
  std::cerr.rdbuf(err_before_);
}

void Output::stop_waiting() {
  out_.stop_waiting();
  err_.stop_waiting();
}

void Output::wait_again(const std::function<bool()>& give_up) {
  out_.wait_again(give_up);
  err_.wait_again(give_up);
}

int Output::end_document(int code) const {
  flush();
  if (!out_.refused()) return code;
  complain("plc-run", "standard output cannot be written");
  return kExitUsage;
}

void Output::flush() {
  std::cout.flush();
  std::cerr.flush();
}

}  // namespace plc::tools
