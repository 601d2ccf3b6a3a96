#include "io-drivers/modbus/serial_server.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <string>

#include "io-drivers/modbus-rtu/line.h"
#include "io-drivers/modbus-rtu/request_stream.h"
#include "runtime/sched/ordinary_thread.h"

namespace plc::modbus {
namespace {

using core::TimeNs;

/// Between attempts at a line that cannot be had.
constexpr TimeNs kOpenAgainNs = 1'000'000'000;
constexpr TimeNs kSweepNs = 100'000'000;
/// More than the kernel needs to take an answer when the line works.
constexpr TimeNs kSendNs = 1'000'000'000;
/// So many pieces without a frame among them are another speed or parity, not noise.
constexpr std::uint64_t kNoFrameAmong = 20;

const char* help_of(int error) {
  switch (error) {
    case EACCES:
    case EPERM:
      return "serial lines belong to the group dialout: the user of plc-run must be in it";
    case EBUSY:
      return "another program has the line: end it, or give this one another line";
    case ENOTTY:
      return "this is no serial line; they are called /dev/ttyS0, /dev/ttyUSB0, /dev/serial/by-id/..";
    default:
      return "see path under [modbus.serial] in plc.toml; /dev/serial/by-id has names that stay";
  }
}

}  // namespace

struct SerialServer::State {
  State(Responder& shared, const io::ModbusSerialConfig& serial)
      : responder(shared),
        path(serial.path.text),
        line_text(serial.line.text),
        line(modbus_rtu::parse_line(serial.line.text).value()),
        unit(serial.unit),
        stream(serial.unit, modbus_rtu::silence_ns(line)) {}

  void run();
  void open();
  void say_listening();
  void lose(int error);
  void wait(TimeNs until_ns);
  void receive();
  void serve();
  void answer(std::span<const std::uint8_t> request);
  bool send(std::span<const std::uint8_t> bytes);
  void say(std::string text, core::Severity severity = core::Severity::kWarning) {
    const std::scoped_lock lock(mutex);
    said.push_back({std::move(text), severity});
  }

  Responder& responder;
  const std::string path, line_text;
  const modbus_rtu::LineSettings line;
  const std::uint8_t unit;
  runtime::OrdinaryThread thread;
  int wake = -1;  ///< readable: stop
  bool started = false;

  // The thread's own.
  core::MonotonicClock clock;
  modbus_rtu::RequestStream stream;
  int fd = -1;
  bool ends = false;
  TimeNs open_at_ns = 0;
  TimeNs sweep_at_ns = 0;
  int refusal = 0;                                    ///< errno, as it was said
  bool quiet = false;                                 ///< the line comes and goes without a frame, which was said
  bool doubted = false;                               ///< that the settings are right, was said
  std::uint64_t heard_frames = 0, heard_damaged = 0;  ///< of the stream, when the line was opened

  std::atomic<std::uint64_t> requests{0}, exceptions{0}, frames{0}, damaged{0};

  std::mutex mutex;  ///< of
  std::vector<io::Sentence> said;
};

void SerialServer::State::open() {
  open_at_ns = clock.now_ns() + kOpenAgainNs;
  fd = modbus_rtu::open_line(path, line);
  if (fd < 0) {
    const int error = -std::exchange(fd, -1);
    if (std::exchange(refusal, error) == error) return;
    quiet = false;
    return say(fmt::format("modbus: {}: cannot listen for Modbus clients on {}: {}; it is tried again ({})",
                           core::info(core::Code::P7510).name, path, std::strerror(error), help_of(error)));
  }
  refusal = 0;
  stream.clear();
  heard_frames = stream.frames();
  heard_damaged = stream.damaged();
  if (!quiet) say_listening();
}

void SerialServer::State::say_listening() {
  say(fmt::format("modbus: listening on {} ({}) as unit {}", path, line_text, unit), core::Severity::kNote);
}

void SerialServer::State::lose(int error) {
  ::close(std::exchange(fd, -1));
  refusal = error;
  open_at_ns = clock.now_ns() + kOpenAgainNs;
  if (!quiet) say(fmt::format("modbus: {} is gone: {}; it is tried again", path, std::strerror(error)));
  quiet = stream.frames() == heard_frames;
}

void SerialServer::State::run() {
  while (!ends) {
    TimeNs now = clock.now_ns();
    if (fd < 0 && now >= open_at_ns) open();
    if (now >= sweep_at_ns) {
      responder.sweep(now);
      sweep_at_ns = now + kSweepNs;
    }
    if (responder.coils_wait()) responder.release_coils();
    TimeNs until = sweep_at_ns;
    if (responder.coils_wait()) until = std::min(until, clock.now_ns() + Responder::kCoilPause);
    if (const auto due = stream.due(); due && fd >= 0) until = std::min(until, *due);
    wait(until);
    if (fd >= 0) serve();
  }
  if (fd >= 0) ::close(fd);
}

/// For bytes, the stop, or the time.
void SerialServer::State::wait(TimeNs until_ns) {
  const TimeNs left = std::max<TimeNs>(until_ns - clock.now_ns(), 0);
  const timespec time = {left / 1'000'000'000, left % 1'000'000'000};
  pollfd both[] = {{wake, POLLIN, 0}, {fd, POLLIN, 0}};
  if (::ppoll(both, fd < 0 ? 1 : 2, &time, nullptr) <= 0) return;
  ends = both[0].revents != 0;
  if (fd >= 0 && both[1].revents != 0) receive();
}

void SerialServer::State::receive() {
  std::array<std::uint8_t, modbus_rtu::RequestStream::kRoom> bytes;
  const ssize_t got = ::read(fd, bytes.data(), bytes.size());
  if (got > 0) return stream.add(std::span(bytes).first(static_cast<std::size_t>(got)), clock.now_ns());
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
  lose(got == 0 ? EIO : errno);  // an adapter that was pulled out: end of file, or EIO
}

void SerialServer::State::serve() {
  for (;;) {
    const auto request = stream.take(clock.now_ns());
    if (request.empty()) break;
    answer(request);
    if (fd < 0) return;
  }
  frames.store(stream.frames(), std::memory_order_relaxed);
  damaged.store(stream.damaged(), std::memory_order_relaxed);
  if (quiet && stream.frames() != heard_frames) {
    quiet = false;
    say_listening();
  }
  const bool doubtful = stream.frames() == heard_frames && stream.damaged() - heard_damaged >= kNoFrameAmong;
  if (!doubtful || std::exchange(doubted, true)) return;
  say(
      fmt::format("modbus: {}: nothing that comes in is a frame: is {} what the others on the line have, and are both "
                  "wires the right way round?",
                  path, line_text));
}

void SerialServer::State::answer(std::span<const std::uint8_t> request) {
  const bool for_all = request[0] == modbus_rtu::kBroadcast;
  std::array<std::uint8_t, modbus_rtu::kMaxFrame> frame;
  frame[0] = unit;
  const auto pdu = request.subspan(1, request.size() - 1 - modbus_rtu::kChecksum);
  const std::size_t size = responder.answer(pdu, std::span(frame).subspan<1, kMaxPdu>(), for_all);
  requests.fetch_add(1, std::memory_order_relaxed);
  if (for_all) return;
  if ((frame[1] & 0x80) != 0) exceptions.fetch_add(1, std::memory_order_relaxed);
  const auto whole = std::span(frame).first(1 + size + modbus_rtu::kChecksum);
  modbus_rtu::seal(whole);
  if (!send(whole)) lose(errno);
}

/// False with errno when the line is lost. What a line does not take in time is left out: its receiver sees half a
/// frame.
bool SerialServer::State::send(std::span<const std::uint8_t> bytes) {
  const TimeNs end = clock.now_ns() + kSendNs;
  while (!bytes.empty() && clock.now_ns() < end) {
    const ssize_t sent = ::write(fd, bytes.data(), bytes.size());
    if (sent > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
    } else if (sent < 0 && errno != EAGAIN && errno != EINTR) {
      return false;
    } else {
      pollfd both[] = {{fd, POLLOUT, 0}, {wake, POLLIN, 0}};
      ::poll(both, 2, 10);
      if (both[1].revents != 0) return true;
    }
  }
  return true;
}

SerialServer::SerialServer(Responder& responder, const io::ModbusSerialConfig& config)
    : state_(std::make_unique<State>(responder, config)) {}

SerialServer::~SerialServer() { stop(); }

void SerialServer::start() {
  State& state = *state_;
  if (std::exchange(state.started, true)) return;
  state.wake = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  state.thread.start("plc-modbus-rtu", [&state] { state.run(); });
}

void SerialServer::stop() {
  State& state = *state_;
  if (state.wake < 0) return;
  const std::uint64_t one = 1;
  static_cast<void>(!::write(state.wake, &one, sizeof one));
  state.thread.join();
  ::close(std::exchange(state.wake, -1));
  state.responder.stopped();
}

std::vector<io::Sentence> SerialServer::take_said() {
  const std::scoped_lock lock(state_->mutex);
  return std::exchange(state_->said, {});
}

SerialStatistics SerialServer::statistics() const {
  const auto value = [](const auto& counter) { return counter.load(std::memory_order_relaxed); };
  SerialStatistics statistics{value(state_->requests), value(state_->exceptions), value(state_->frames),
                              value(state_->damaged)};
  statistics.others -= std::min(statistics.others, statistics.requests);
  return statistics;
}

}  // namespace plc::modbus
