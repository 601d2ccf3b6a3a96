#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <utility>

#include "log/format.h"
#include "log/sink.h"

namespace plc::log {
namespace {

class StreamSink final : public Sink {
 public:
  StreamSink(std::ostream& out, std::string (*line)(const Record&)) : out_(out), line_(line) {}
  void write(const Record& record) override { out_ << line_(record); }
  void flush() override { out_.flush(); }

 private:
  std::ostream& out_;
  std::string (*line_)(const Record&);
};

/// WHY not sd_journal_sendv(): it waits for a journal that stalls, and this is the thread that serves devices.
class JournalSink final : public Sink {
 public:
  explicit JournalSink(const std::string& path) : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    address_.sun_family = AF_UNIX;
    if (path.size() >= sizeof address_.sun_path) {
      too_long_ = true;
    } else {
      std::memcpy(address_.sun_path, path.c_str(), path.size() + 1);
    }
  }
  ~JournalSink() override {
    if (fd_ >= 0) ::close(fd_);
  }
  JournalSink(const JournalSink&) = delete;
  JournalSink& operator=(const JournalSink&) = delete;

  void write(const Record& record) override {
    std::string datagram = journal_datagram(record);
    if (bytes_ + datagram.size() > kMostWaiting) {
      ++lost_;
      return;
    }
    bytes_ += datagram.size();
    waiting_.push_back({std::move(datagram), record});
    flush();
  }

  void flush() override {
    while (!waiting_.empty() && send(waiting_.front().bytes)) {
      bytes_ -= waiting_.front().bytes.size();
      waiting_.pop_front();
    }
    if (!waiting_.empty() || lost_ == 0) return;
    Record record;
    record.severity = core::Severity::kWarning;
    record.text = fmt::format("{} messages are lost: the journal did not take them", lost_);
    if (send(journal_datagram(record))) lost_ = 0;
  }

  [[nodiscard]] std::string problem() const override {
    return error_ == 0 ? std::string() : std::string(std::strerror(error_));
  }

  std::vector<Record> take_unshown(core::Severity least) override { return take_unshown_of(waiting_, least); }
  [[nodiscard]] std::uint64_t lost() const override { return lost_; }

 private:
  static constexpr std::size_t kMostWaiting = 1'048'576;

  /// True when nobody has to send it again.
  bool send(const std::string& datagram) {
    const auto sent = too_long_ ? (errno = ENAMETOOLONG, -1)
                                : ::sendto(fd_, datagram.data(), datagram.size(), MSG_NOSIGNAL,
                                           reinterpret_cast<const sockaddr*>(&address_), sizeof address_);
    if (sent >= 0) {
      error_ = 0;
      return true;
    }
    if (errno == EMSGSIZE) {
      ++lost_;
      return true;
    }
    // A journal that is behind is no problem yet: what waits is sent when it has caught up.
    error_ = errno == EAGAIN || errno == EINTR ? 0 : errno;
    return false;
  }

  int fd_;
  sockaddr_un address_{};
  bool too_long_ = false;
  std::deque<Waiting> waiting_;
  std::size_t bytes_ = 0;
  std::uint64_t lost_ = 0;
  int error_ = 0;
};

}  // namespace

std::unique_ptr<Sink> stream_sink(std::ostream& out, std::string (*line)(const Record&)) {
  return std::make_unique<StreamSink>(out, line);
}

std::unique_ptr<Sink> journal_sink(const std::string& socket) { return std::make_unique<JournalSink>(socket); }

}  // namespace plc::log
