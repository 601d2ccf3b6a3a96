#include "engineering/streams.h"

#include <nlohmann/json.hpp>

#include "engineering/flow_stream.h"
#include "engineering/log_json.h"
#include "engineering/value_stream.h"

namespace plc::engineering {
namespace {

class LogStream final : public Stream {
 public:
  LogStream(Context& context, const Json& request)
      : log_(context.log),
        least_(severity_named(request.value("least", "note"))),
        seen_(request.contains("after") ? request["after"].get<std::uint64_t>() : context.log.last_number()) {}

  std::string take(std::string_view) override { return {}; }

  std::optional<Frame> next() override {
    const std::uint64_t first = log_.first_number();
    if (seen_ + 1 < first) {
      const std::uint64_t missed = first - 1 - seen_;
      seen_ = first - 1;
      return Frame{false, Json{{"missed", missed}}.dump()};
    }
    const auto found = log_.after(seen_, least_, 1);
    if (found.empty()) return std::nullopt;
    seen_ = found.front().number;
    return Frame{false, log_json(found.front()).dump(-1, ' ', false, Json::error_handler_t::replace)};
  }

  [[nodiscard]] core::TimeNs period_ns() const override { return 50'000'000; }

 private:
  LogBook& log_;
  core::Severity least_;
  std::uint64_t seen_;
};

}  // namespace

std::unique_ptr<Stream> make_stream(const Call& call, Context& context, const Json& request) {
  if (call.name == "log.stream") return std::make_unique<LogStream>(context, request);
  if (call.name == "diagrams.stream")
    return std::make_unique<FlowStream>(context, request.value("period_ms", std::int64_t{50}) * 1'000'000);
  return std::make_unique<ValueStream>(context, request.value("period_ms", std::int64_t{100}) * 1'000'000);
}

}  // namespace plc::engineering
