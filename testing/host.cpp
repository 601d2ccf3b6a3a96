#include "testing/host.h"

#include <stdexcept>

#include "picard/taskblock.h"

namespace plc::tests {
namespace {

thread_local HostListener* current = nullptr;

class TestHost final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = ir::kTestHostType, .group = "Tests", .summary = "What a test asks of plc test."};
  picard::Input<std::uint32_t> call{this, ir::kTestHostCall, "position in ir/test_calls.def"};
  picard::Input<std::uint32_t> site{this, ir::kTestHostSite, "assertion"};
  picard::Input<bool> holds{this, ir::kTestHostHolds, "the assertion holds"};
  picard::Input<std::int64_t> cycles{this, ir::kTestHostCycles, "release instants to run"};
  picard::Input<picard::Time> span{this, ir::kTestHostSpan, "virtual time to pass"};
  picard::Input<picard::LdateAndTime> date{this, ir::kTestHostDate, "date and time from here on"};

  void fire() override {
    HostCall said;
    said.call = static_cast<ir::TestCall>(static_cast<std::uint32_t>(call));
    said.site = site;
    said.holds = holds;
    said.cycles = cycles;
    said.span_ns = static_cast<picard::Time>(span).count();
    said.utc_ns = static_cast<picard::LdateAndTime>(date);
    if (listener_ == nullptr || !listener_->on_call(said)) throw std::runtime_error("the test ends here");
  }

 private:
  HostListener* listener_ = current;
};

}  // namespace

PICARD_LINKED_LIBRARY(host_library, "tests", "1.0.0", TestHost)

HostScope::HostScope(HostListener& listener) { current = &listener; }
HostScope::~HostScope() { current = nullptr; }

}  // namespace plc::tests
