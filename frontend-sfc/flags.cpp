// Flags of CODESYS and TwinCAT: variables of the POU by which a program holds, restarts and watches its charts. They
// are read when the chart is evaluated, so each chart of a POU sees them at its own next call.
#include "core/text.h"
#include "frontend-sfc/evaluation.h"
#include "frontend-st/names.h"
#include "stdlib/library.h"

namespace plc::sfc {

using core::Code;
using ir::ValueId;

namespace {

struct FlagRow {
  std::string_view name;
  core::TypeId type;
};
constexpr FlagRow kFlags[] = {
#define PLC_SFC_FLAG(Name, name, Type) {name, core::TypeId::k##Type},
#include "frontend-sfc/flags.def"
};
constexpr ir::TypeRef kTime = ir::ref_of(core::TypeId::kTime);

}  // namespace

void Evaluation::find_flags() {
  for (std::size_t i = 0; i < std::size(kFlags); ++i) {
    const st::Named named = st::find_name(b_.module(), b_.pou(), kFlags[i].name);
    if (!named.is_place()) continue;
    const bool local = named.kind == st::Named::Kind::kVariable;
    const ir::PlaceId place = local ? b_.variable(named.index) : b_.global(named.index);
    const auto type = b_.module().types.elementary_of(b_.type_of(place));
    if (type != kFlags[i].type) {
      const core::SourceRef& where =
          local ? b_.pou().variables[named.index].at : b_.module().globals[named.index].variable.at;
      b_.report(Code::P3109, where,
                std::string(kFlags[i].name) + " has type " + b_.module().types.name_of(b_.type_of(place)) +
                    ", as a flag of a chart it is " + std::string(core::name_of(kFlags[i].type)),
                "declare it with that type, or rename it");
      continue;
    }
    flags_[i] = place;
  }
  for (const std::string_view refused : {"SFCErrorAnalyzation", "SFCErrorAnalyzationTable"}) {
    const st::Named named = st::find_name(b_.module(), b_.pou(), refused);
    if (named.kind != st::Named::Kind::kVariable) continue;
    b_.report(Code::P3109, b_.pou().variables[named.index].at,
              std::string(refused) + " is not supported: what made the error is not analysed",
              "remove it; SFCErrorStep names the step");
  }
}

void Evaluation::set(Flag flag, bool value) {
  if (has(flag)) b_.store(*flags_[static_cast<std::size_t>(flag)], b_.constant_bool(value));
}

void Evaluation::set(Flag flag, const std::string& text) {
  if (!has(flag)) return;
  ir::Constant constant;
  constant.type =
      b_.module().types.string(core::TypeId::kString, static_cast<std::uint16_t>(text.empty() ? 1 : text.size()));
  constant.text = text;
  b_.assign(*flags_[static_cast<std::size_t>(flag)], ir::Operand::of(b_.constant(constant)), "flag of a chart");
}

/// The time of this evaluation. While SFCPause holds the chart, its time stands still.
void Evaluation::take_time() {
  const stdlib::BlockSpec* const spec = stdlib::block_named("UPTIME");
  const ir::PlaceId clock = b_.variable(b_.hidden("now", b_.module().types.block(*spec)));
  b_.run(clock);
  now_ = b_.load(b_.field(clock, 0));
  if (!has(Flag::kPause) && !has(Flag::kQuitError)) return;
  last_time_ = b_.hidden("last", kTime);
  lost_time_ = b_.hidden("lost", kTime);
}

void Evaluation::clear_errors() {
  set(Flag::kError, false);
  set(Flag::kErrorStep, std::string());
  set(Flag::kErrorPou, std::string());
}

/// The marking becomes the initial one in this evaluation; a step of it that is active already stays so.
void Evaluation::restart() {
  steps_tree_.walk([&](std::uint32_t s) {
    store(chart_.steps[s].on, false);
    store(chart_.steps[s].off, active(s));
  });
  begin();
}

void Evaluation::obey_flags() {
  if (has(Flag::kInit)) {
    quiet_ = b_.hidden("quiet", ir::kBoolType);
    store(quiet_, flag(Flag::kInit));
  }
  if (has(Flag::kInit) || has(Flag::kReset)) {
    restarted_ = b_.hidden("restarted", ir::kBoolType);
    ValueId again = has(Flag::kInit) ? load(quiet_) : b_.constant_bool(false);
    if (has(Flag::kReset)) again = or_(again, flag(Flag::kReset));
    store(restarted_, again);
    when(load(restarted_), [&] { restart(); });
  }
  if (has(Flag::kInit)) {
    when(load(quiet_), [&] { clear_errors(); });
  }
  if (last_time_ != kNoVariable) {
    const auto stand_still = [&](ValueId flag, const Emit& also) {
      const ValueId stops = quiet_ == kNoVariable ? flag : and_(flag, b_.not_(load(quiet_)));
      when(stops, [&] {
        also();
        const ir::Operand operands[] = {ir::Operand::of(load(lost_time_)),
                                        ir::Operand::of(minus(now_, load(last_time_)))};
        store(lost_time_, *b_.call("ADD", operands, c_.at, kTime));
        store(last_time_, now_);
        b_.jump(end_);
      });
    };
    if (has(Flag::kPause)) stand_still(flag(Flag::kPause), [] {});
    if (has(Flag::kQuitError)) {
      quitting_ = b_.hidden("quitting", ir::kBoolType);
      stand_still(flag(Flag::kQuitError), [&] {
        clear_errors();
        store(quitting_, true);
      });
    }
    store(last_time_, now_);
    now_ = minus(now_, load(lost_time_));
    if (quitting_ != kNoVariable) {
      when(load(quitting_), [&] {
        store(quitting_, false);
        steps_tree_.walk([&](std::uint32_t s) { when(active(s), [&] { store(chart_.steps[s].since, now_); }); });
      });
    }
  }
  if (has(Flag::kTip)) {
    tipped_ = b_.hidden("tipped", ir::kBoolType);
    tip_ = b_.hidden("tip", ir::kBoolType);
    store(tip_, and_(flag(Flag::kTip), b_.not_(load(tipped_))));
    store(tipped_, flag(Flag::kTip));
  }
}

/// Maximal time of an active step, and its name for SFCCurrentStep.
void Evaluation::watch_time(std::uint32_t s) {
  const Step& step = c_.steps[s];
  set(Flag::kCurrentStep, step.name);
  if (step.max_time.empty() || !has(Flag::kError)) return;
  const auto most = duration(step.max_time, step.at, "maximal time of a step");
  if (!most) return;
  ValueId late = and_(compare("GT", b_.load(time(s)), *most), b_.not_(flag(Flag::kError)));
  if (has(Flag::kEnableLimit)) late = and_(late, flag(Flag::kEnableLimit));
  when(late, [&] {
    set(Flag::kError, true);
    set(Flag::kErrorStep, step.name);
    set(Flag::kErrorPou, b_.pou().name);
  });
}

}  // namespace plc::sfc
