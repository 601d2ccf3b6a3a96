#include "io-drivers/trace.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <system_error>

#include "io-drivers/csv.h"
#include "io-drivers/stimulus.h"

namespace plc::io {
namespace {
constexpr std::size_t kFlushBytes = 1 << 16;
constexpr int kInMemory = -1;
}  // namespace

core::Result<std::unique_ptr<TraceWriter>> TraceWriter::open(const std::string& file,
                                                             const std::vector<std::string>& paths,
                                                             runtime::Resource& resource, runtime::ValueStyle style) {
  std::unique_ptr<TraceWriter> trace(new TraceWriter(kInMemory, resource));
  trace->style_ = style;
  trace->name_ = file == "-" ? "standard output" : file;
  trace->buffer_ = "cycle,time_ms";
  for (const std::string& path : paths) {
    const auto place = trace->access_.find_leaf(path);
    if (!place) return place.error();
    const bytecode::ImageType& type = resource.image().types[place->type];
    const bool text = type.kind == bytecode::TypeKind::kString || core::in_category(type.elementary, core::kAnyChar);
    trace->places_.push_back(*place);
    trace->may_need_quotes_.push_back(text ? 1 : 0);
    trace->buffer_ += ',';
    append_csv(trace->buffer_, path);
  }
  trace->buffer_ += '\n';
  if (file == "-") {
    trace->descriptor_ = STDOUT_FILENO;
  } else if (!file.empty()) {
    trace->descriptor_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (trace->descriptor_ < 0) {
      return core::Problem{core::Code::P7001, file + ": " + std::system_category().message(errno), {}};
    }
  }
  return trace;
}

TraceWriter::~TraceWriter() { static_cast<void>(close()); }

void TraceWriter::record(const runtime::Instant& instant) {
  char number[24];
  const auto end = std::to_chars(number, number + sizeof number, instant.cycle).ptr;
  buffer_.append(number, end);
  buffer_ += ',';
  append_time_ms(buffer_, instant.now_ns);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    buffer_ += ',';
    if (may_need_quotes_[i] == 0) {
      access_.read_to(places_[i], buffer_, style_);
    } else {
      append_csv(buffer_, access_.read(places_[i]));
    }
  }
  buffer_ += '\n';
  if (descriptor_ != kInMemory && buffer_.size() >= kFlushBytes) flush();
}

void TraceWriter::attach(runtime::Simulation& simulation) {
  simulation.after_instant([this](const runtime::Instant& instant) { record(instant); });
}

void TraceWriter::flush() {
  for (std::size_t at = 0; at < buffer_.size() && error_ == 0;) {
    const ssize_t written = ::write(descriptor_, buffer_.data() + at, buffer_.size() - at);
    if (written < 0 && errno != EINTR) error_ = errno;
    if (written > 0) at += static_cast<std::size_t>(written);
  }
  buffer_.clear();
}

std::optional<core::Problem> TraceWriter::close() {
  if (descriptor_ == kInMemory) return std::nullopt;
  flush();
  if (descriptor_ != STDOUT_FILENO && ::close(descriptor_) != 0 && error_ == 0) error_ = errno;
  descriptor_ = kInMemory;
  if (error_ == 0) return std::nullopt;
  return core::Problem{core::Code::P7203, name_ + ": " + std::system_category().message(error_), {}};
}

}  // namespace plc::io
