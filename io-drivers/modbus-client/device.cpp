#include "io-drivers/modbus-client/device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace plc::modbus_client {
namespace {

constexpr TimeNs kNever = std::numeric_limits<TimeNs>::max();
/// How old the age in the table may be.
constexpr TimeNs kStatusNs = 50'000'000;
constexpr std::uint32_t kLastBit = 63;
/// A device that comes and goes fills no log.
constexpr std::uint32_t kSaidPerMinute = 10;
constexpr TimeNs kMinuteNs = 60'000'000'000;

std::string_view table_text(ModbusTable table) {
  constexpr std::string_view kTexts[] = {"coil", "discrete input", "input register", "holding register"};
  return kTexts[static_cast<std::size_t>(table)];
}

template <class Points>
std::vector<Want> wants_of(const Points& points) {
  std::vector<Want> wants;
  for (const auto& point : points) wants.push_back(point.want);
  return wants;
}

}  // namespace

Device::Device(DeviceSettings settings, std::uint32_t task, std::vector<ReadPoint> reads,
               std::vector<StatusPoint> status, std::vector<WritePoint> writes, std::span<const std::uint32_t> claimed,
               runtime::GlobalTable& table)
    : settings_(std::move(settings)),
      task_(task),
      reads_(std::move(reads)),
      status_(std::move(status)),
      writes_(std::move(writes)) {
  std::uint32_t most = sizeof(std::uint64_t);
  for (const ReadPoint& point : reads_) most = std::max(most, point.bytes);
  for (const WritePoint& point : writes_) most = std::max(most, point.bytes);
  value_.resize(most);
  if (!claimed.empty()) to_table_.emplace(table, claimed);
  if (!writes_.empty()) from_table_.emplace(table);
  for (Block& block : plan(wants_of(reads_), settings_.read_limits)) {
    read_parts_.emplace_back().block = std::move(block);
  }
  for (Block& block : plan(wants_of(writes_), settings_.write_limits)) {
    write_parts_.emplace_back().block = std::move(block);
  }
}

void Device::begin(TimeNs now_ns) {
  const std::scoped_lock lock(mutex_);
  began_ns_ = now_ns;
  look_at_ns_ = status_at_ns_ = now_ns;
  for (Part& part : read_parts_) {
    part.due_ns = now_ns;
    substitute(part);
  }
  publish(now_ns, true);
}

TimeNs Device::due() const {
  TimeNs due = status_.empty() ? kNever : status_at_ns_;
  if (lost_) return std::min(due, retry_at_ns_);
  if (!write_parts_.empty()) due = std::min(due, look_at_ns_);
  for (const Part& part : write_parts_) {
    if (!part.valid || part.wanted != part.written) due = std::min(due, part.due_ns);
  }
  for (const Part& part : read_parts_) due = std::min(due, part.due_ns);
  return due;
}

void Device::turn(Link& link, const core::Clock& clock) {
  const TimeNs now = clock.now_ns();
  if (lost_ && now < retry_at_ns_) return publish(now, false);
  if (!write_parts_.empty() && (now >= look_at_ns_ || lost_)) look(now);
  Part* write = next_write(now);
  Part* read = next_read(now);
  if (write != nullptr && read != nullptr) (write_next_ ? read : write) = nullptr;
  if (write == nullptr && read == nullptr) return publish(now, false);
  write_next_ = write == nullptr;
  exchange(write != nullptr ? *write : *read, write != nullptr, link, clock);
}

const std::byte* Device::value_of(const WritePoint& point, std::byte* buffer) const {
  if (held_.load(std::memory_order_relaxed)) return point.safe.data();
  const std::uint64_t stopped = stopped_tasks_.load(std::memory_order_relaxed);
  const auto is_stopped = [&](std::uint32_t task) { return (stopped >> std::min(task, kLastBit) & 1) != 0; };
  if (is_stopped(task_) || std::ranges::any_of(point.exporters, is_stopped)) return point.safe.data();
  if (!scanned_.load(std::memory_order_acquire)) return point.initial.data();
  from_table_->read(point.offset, point.bytes, buffer);
  return buffer;
}

void Device::look(TimeNs now_ns) {
  from_table_->take();
  for (Part& part : write_parts_) {
    part.wanted.assign(part.block.count, 0);
    for (const std::uint32_t i : part.block.wants) {
      const WritePoint& point = writes_[i];
      encode(point.coding, value_of(point, value_.data()),
             std::span(part.wanted).subspan(point.want.first - part.block.first, point.want.count));
    }
    // Written again although nothing changed: the device may have lost it.
    if (settings_.rewrite_ns != 0 && now_ns >= part.rewrite_at_ns) part.valid = false;
  }
  look_at_ns_ = now_ns + settings_.write_ns;
}

Device::Part* Device::next_write(TimeNs now_ns) {
  Part* next = nullptr;
  for (Part& part : write_parts_) {
    const bool differs = !part.valid || part.wanted != part.written;
    if (!differs || (!lost_ && part.due_ns > now_ns)) continue;
    if (next == nullptr || part.due_ns < next->due_ns) next = &part;
  }
  return next;
}

Device::Part* Device::next_read(TimeNs now_ns) {
  Part* next = nullptr;
  for (Part& part : read_parts_) {
    if (!lost_ && part.due_ns > now_ns) continue;
    if (next == nullptr || part.due_ns < next->due_ns) next = &part;
  }
  return next;
}

void Device::exchange(Part& part, bool write, Link& link, const core::Clock& clock) {
  const Block& block = part.block;
  const Bytes pdu = write ? write_pdu(block.table, block.first, part.wanted, settings_.multiple)
                          : read_pdu(block.table, block.first, block.count);
  Cells cells;
  const Error error = ask(link, settings_.unit, pdu, settings_.timeout_ns, cells);
  const TimeNs now = clock.now_ns();
  const std::scoped_lock lock(mutex_);
  if (error == Error::kNone) return succeeded(part, write, cells, now);
  if (is_exception(error)) return refused(part, write, error, now);
  failed(part, write, error, link.reason(), now);
}

void Device::succeeded(Part& part, bool write, const Cells& cells, TimeNs now_ns) {
  ++exchanges_;
  answered_ns_ = now_ns;
  came_back(now_ns);
  if (part.backoff_ns != 0) {
    say(now_ns, fmt::format("{} can be {} again", cells_text(part.block), write ? "written" : "read"),
        core::Severity::kNote);
  }
  part.error = Error::kNone;
  part.backoff_ns = 0;
  part.failures = 0;
  if (write) {
    part.written = part.wanted;
    part.valid = true;
    part.due_ns = now_ns;
    part.rewrite_at_ns = now_ns + settings_.rewrite_ns;
    return publish(now_ns, false);
  }
  part.read_at_ns = now_ns;
  // On the grid; what the bus cannot keep up with is left out.
  part.due_ns += part.block.period_ns;
  if (part.due_ns <= now_ns)
    part.due_ns = now_ns + part.block.period_ns - (now_ns - part.due_ns) % part.block.period_ns;
  for (const std::uint32_t i : part.block.wants) {
    const ReadPoint& point = reads_[i];
    decode(point.coding, std::span(cells).subspan(point.want.first - part.block.first, point.want.count),
           value_.data());
    to_table_->set(point.offset, point.type, value_.data());
  }
  publish(now_ns, true);
}

TimeNs Device::longer(TimeNs backoff_ns) const {
  if (backoff_ns == 0) return settings_.retry_ns;
  return std::max(settings_.retry_ns, std::min(backoff_ns * 2, settings_.retry_max_ns));
}

void Device::refused(Part& part, bool write, Error error, TimeNs now_ns) {
  answered_ns_ = now_ns;
  came_back(now_ns);
  if (!write && part.block.gaps && error == Error::kIllegalAddress && split(part, now_ns)) return;
  part.failures = 0;
  put_off(part, write, error, now_ns);
}

void Device::put_off(Part& part, bool write, Error error, TimeNs now_ns) {
  // Also where the device was lost by it before.
  if (part.error != error || part.backoff_ns == 0) {
    say(now_ns,
        fmt::format("{} cannot be {}: {}", cells_text(part.block), write ? "written" : "read", error_text(error)));
  }
  part.error = error;
  part.valid = false;
  part.backoff_ns = longer(part.backoff_ns);
  part.due_ns = now_ns + part.backoff_ns;
  if (!write) substitute(part);
  publish(now_ns, true);
}

bool Device::split(const Part& part, TimeNs now_ns) {
  Limits limits = settings_.read_limits;
  limits.gap = 0;
  std::vector<Want> wants;
  for (const std::uint32_t i : part.block.wants) wants.push_back(reads_[i].want);
  std::vector<Part> parts;
  for (Block& block : plan(wants, limits)) {
    for (std::uint32_t& want : block.wants) want = part.block.wants[want];
    Part& one = parts.emplace_back();
    one.block = std::move(block);
    one.due_ns = now_ns;
    one.read_at_ns = part.read_at_ns;
  }
  if (parts.size() < 2) return false;
  say(now_ns, fmt::format("{} have addresses that it does not have between them: they are read in {} requests",
                          cells_text(part.block), parts.size()));
  read_parts_.erase(read_parts_.begin() + (&part - read_parts_.data()));
  read_parts_.insert(read_parts_.end(), parts.begin(), parts.end());
  return true;
}

void Device::failed(Part& part, bool write, Error error, std::string_view reason, TimeNs now_ns) {
  // Also of a device that is lost: the next attempt asks for something else, which it may answer.
  part.due_ns = now_ns;
  if (!lost_) {
    part.valid = false;
    ++part.failures;
    // Where nobody listens, nobody will in the next instant.
    if (++failures_ <= settings_.retries && error != Error::kNotConnected) {
      // It answers others: many devices say nothing to what they do not have.
      if (part.failures > settings_.retries) put_off(part, write, error, now_ns);
      return;
    }
    lost_ = true;
    lost_since_ns_ = now_ns;
    ++losses_;
    backoff_ns_ = 0;
    for (Part& one : read_parts_) {
      one.error = error;
      if (&one != &part) one.due_ns = std::min(one.due_ns, now_ns - 1);
      substitute(one);
    }
    for (Part& one : write_parts_) {
      one.error = error;
      one.valid = false;
    }
  }
  backoff_ns_ = longer(backoff_ns_);
  retry_at_ns_ = now_ns + backoff_ns_;
  std::string problem = error_text(error);
  if (!reason.empty()) problem += fmt::format(" ({})", reason);
  if (problem != problem_) say(now_ns, fmt::format("{}: {}", settings_.where, problem));
  problem_ = std::move(problem);
  lost_error_ = error;
  publish(now_ns, true);
}

void Device::came_back(TimeNs now_ns) {
  failures_ = 0;
  if (!lost_) return;
  lost_ = false;
  lost_error_ = Error::kNone;
  ++recoveries_;
  problem_.clear();
  for (Part& part : read_parts_) part.due_ns = now_ns;
  for (Part& part : write_parts_) part.due_ns = now_ns;
  say(now_ns,
      fmt::format("{} is back after {:.1f} s", settings_.where, static_cast<double>(now_ns - lost_since_ns_) / 1e9),
      core::Severity::kNote);
}

void Device::substitute(const Part& part) {
  for (const std::uint32_t i : part.block.wants) {
    const ReadPoint& point = reads_[i];
    if (!point.substitute.empty()) to_table_->set(point.offset, point.type, point.substitute.data());
  }
}

Error Device::error() const {
  if (lost_) return lost_error_;
  Error first = Error::kNone;
  for (const auto* parts : {&read_parts_, &write_parts_}) {
    for (const Part& part : *parts) {
      if (first == Error::kNone || (first == Error::kNeverRead && part.error != Error::kNone)) first = part.error;
    }
  }
  return first;
}

TimeNs Device::age_ns(TimeNs now_ns) const {
  TimeNs since = read_parts_.empty() ? std::max(answered_ns_, began_ns_) : now_ns;
  for (const Part& part : read_parts_) since = std::min(since, part.read_at_ns < 0 ? began_ns_ : part.read_at_ns);
  return now_ns - since;
}

void Device::publish(TimeNs now_ns, bool changed) {
  if (!to_table_) return;
  const Error now = error();
  const bool due = !status_.empty() && now_ns >= status_at_ns_;
  if (!changed && !due && now == published_) return;
  published_ = now;
  status_at_ns_ = now_ns + kStatusNs;
  for (const StatusPoint& point : status_) {
    std::byte value[8] = {};
    if (point.what == Status::kOk) {
      value[0] = std::byte{now == Error::kNone ? std::uint8_t{1} : std::uint8_t{0}};
    } else {
      const std::int64_t number = point.what == Status::kAge ? age_ns(now_ns) : static_cast<std::int64_t>(now);
      std::memcpy(value, &number, sizeof number);  // little-endian: narrower integers take the low bytes
    }
    to_table_->set(point.offset, point.type, value);
  }
  to_table_->publish();
}

bool Device::write_safe(Link& link) const {
  std::vector<Bytes> left;
  for (const Part& part : write_parts_) {
    Cells cells(part.block.count, 0);
    for (const std::uint32_t i : part.block.wants) {
      const WritePoint& point = writes_[i];
      encode(point.coding, point.safe.data(),
             std::span(cells).subspan(point.want.first - part.block.first, point.want.count));
    }
    left.push_back(write_pdu(part.block.table, part.block.first, cells, settings_.multiple));
  }
  // One that is lost has been asked often enough.
  const std::uint32_t retries = lost_ ? 0 : settings_.retries;
  std::size_t silent = 0;  // in a row
  // All once before any of them again: some devices say nothing to what they do not have.
  for (std::uint32_t attempt = 0; attempt <= retries && !left.empty(); ++attempt) {
    std::vector<Bytes> failed;
    for (Bytes& pdu : left) {
      Cells none;
      const Error error = ask(link, settings_.unit, pdu, settings_.timeout_ns, none);
      if (error == Error::kNotConnected || (lost_ && error == Error::kNoAnswer)) return false;
      silent = error == Error::kNoAnswer ? silent + 1 : 0;
      if (error != Error::kNone) failed.push_back(std::move(pdu));
    }
    if (silent >= left.size() && silent > retries) return false;
    left = std::move(failed);
  }
  return left.empty();
}

// RT:
void Device::task_stopped(std::uint32_t task) noexcept {
  stopped_tasks_.fetch_or(std::uint64_t{1} << std::min(task, kLastBit), std::memory_order_relaxed);
}

std::string Device::cells_text(const Block& block) const {
  const std::string_view table = table_text(block.table);
  if (block.count == 1) return fmt::format("{}: {} {}", settings_.where, table, block.first);
  return fmt::format("{}: {}s {} to {}", settings_.where, table, block.first, block.first + block.count - 1);
}

void Device::say(TimeNs now_ns, std::string sentence, core::Severity severity) {
  if (now_ns - said_since_ns_ >= kMinuteNs || said_count_ == 0) {
    said_since_ns_ = now_ns;
    said_count_ = 0;
  }
  if (++said_count_ > kSaidPerMinute) {
    ++unsaid_;
    return;
  }
  said_.push_back({settings_.name + ": " + std::move(sentence), severity});
}

std::vector<io::Sentence> Device::take_said(TimeNs now_ns) {
  const std::scoped_lock lock(mutex_);
  std::vector<io::Sentence> said = std::exchange(said_, {});
  if (unsaid_ != 0 && now_ns - said_since_ns_ >= kMinuteNs) {
    said.push_back({fmt::format("{}: {} more changes in the last minute", settings_.name, unsaid_)});
    unsaid_ = said_count_ = 0;
  }
  return said;
}

io::DriverStatus Device::status() const {
  const std::scoped_lock lock(mutex_);
  return {!lost_ && answered_ns_ >= 0, losses_, recoveries_, exchanges_, problem_};
}

std::vector<io::InputStatus> Device::inputs(TimeNs now_ns) const {
  const std::scoped_lock lock(mutex_);
  std::vector<io::InputStatus> all(reads_.size());
  for (const Part& part : read_parts_) {
    const bool never = part.read_at_ns < 0;
    const io::Quality quality = never                                  ? io::Quality::kNever
                                : !lost_ && part.error == Error::kNone ? io::Quality::kGood
                                                                       : io::Quality::kLost;
    for (const std::uint32_t i : part.block.wants) {
      all[i] = {reads_[i].variable, quality, never ? 0 : std::max<TimeNs>(now_ns - part.read_at_ns, 0)};
    }
  }
  return all;
}

}  // namespace plc::modbus_client
