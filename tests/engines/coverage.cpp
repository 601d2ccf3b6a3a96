#include "tests/engines/coverage.h"

#include <fmt/format.h>

#include <ostream>

#include "native/operation.h"
#include "runtime/link/link.h"

namespace plc::test {

namespace {
std::string_view name_of(std::size_t op) { return native::name_of(static_cast<runtime::ResolvedOp>(op)); }
}  // namespace

Engine Coverage::native_code() {
  return {"native code", [this](runtime::Program& program) -> core::Result<std::unique_ptr<runtime::CompiledTask>> {
            auto compiled = native::compile(program);
            if (!compiled) return compiled.error();
            std::array<std::uint32_t, kOps> left{};
            for (const runtime::LinkedInstruction& i : program.linked().instructions)
              ++left[static_cast<std::size_t>(i.op)];
            for (const auto& [op, count] : (*compiled)->report().interpreted) {
              rows_[static_cast<std::size_t>(op)].interpreted.add(program_);
              left[static_cast<std::size_t>(op)] -= count;
            }
            for (const runtime::LinkedInstruction& i : program.linked().arranged)
              rows_[static_cast<std::size_t>(i.op)].interpreted.add(program_);
            for (std::size_t op = 0; op < kOps; ++op) {
              if (left[op] != 0) rows_[op].compiled.add(program_);
            }
            return std::unique_ptr<runtime::CompiledTask>(std::move(*compiled));
          }};
}

void Coverage::print_summary(std::ostream& out) const {
  // That one is in replicas which somebody looks at: --probes.
  constexpr auto kProbe = static_cast<std::size_t>(runtime::ResolvedOp::kProbe);
  std::string never;
  std::size_t seen = 0;
  for (std::size_t op = 0; op < kOps; ++op) {
    if (op == kProbe) continue;
    if (rows_[op].compiled.programs + rows_[op].interpreted.programs != 0) {
      ++seen;
    } else {
      never += fmt::format(" {}", name_of(op));
    }
  }
  out << fmt::format("{} of {} kinds of instruction", seen, kOps - 1) << (never.empty() ? "" : "; never:" + never)
      << '\n';
}

void Coverage::print(std::ostream& out) const {
  out << fmt::format("{:<20} {:>12} {:>12}\n", "programs with", "native code", "interpreter");
  for (std::size_t op = 0; op < kOps; ++op) {
    out << fmt::format("{:<20} {:>12} {:>12}\n", name_of(op), rows_[op].compiled.programs,
                       rows_[op].interpreted.programs);
  }
}

}  // namespace plc::test
