#include "bench/program.h"

#include <algorithm>
#include <random>
#include <utility>

namespace plc::bench {
namespace {

constexpr std::uint32_t kMaxContacts = 12;
constexpr int kMaxNesting = 3;

/// Draws from a seed; std::uniform_int_distribution may differ between libraries, a modulus does not.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  std::uint32_t below(std::uint32_t bound) { return static_cast<std::uint32_t>(engine_() % bound); }
  bool chance(std::uint32_t percent) { return below(100) < percent; }

 private:
  std::mt19937_64 engine_;
};

/// What contacts read: any BOOL, or with `inputs` every other time one that is an input.
struct Readable {
  std::uint32_t count = 0;
  std::uint32_t inputs = 0;
};

Net contact(Dice& dice, Readable readable) {
  Net net;
  net.variable = dice.below(readable.inputs != 0 && dice.chance(50) ? readable.inputs : readable.count);
  // WHY half: a ladder of plain contacts goes all FALSE after a few scans and would compare nothing.
  net.negated = dice.chance(50);
  return net;
}

/// `contacts` contacts in series or parallel; alternate levels nest as long as `nesting` allows.
Net random_net(Dice& dice, std::uint32_t contacts, bool parallel, int nesting, Readable readable) {
  if (contacts == 1) return contact(dice, readable);
  Net net;
  net.kind = parallel ? Net::Kind::kParallel : Net::Kind::kSeries;
  while (contacts > 0) {
    // WHY at most contacts - 1 in the first part: a net of one child would not be a branch.
    const std::uint32_t most = net.children.empty() ? contacts - 1 : contacts;
    const bool nest = nesting > 0 && most >= 2 && dice.chance(50);
    const std::uint32_t part = nest ? 2 + dice.below(most - 1) : 1;
    net.children.push_back(nest ? random_net(dice, part, !parallel, parallel ? nesting : nesting - 1, readable)
                                : contact(dice, readable));
    contacts -= part;
  }
  return net;
}

/// (a OR b) AND c AND d, any of them negated.
Net plain_net(Dice& dice, Readable readable) {
  Net branch;
  branch.kind = Net::Kind::kParallel;
  for (int i = 0; i < 2; ++i) branch.children.push_back(contact(dice, readable));
  Net net;
  net.kind = Net::Kind::kSeries;
  net.children.push_back(std::move(branch));
  for (int i = 0; i < 2; ++i) net.children.push_back(contact(dice, readable));
  return net;
}

/// Makes the rungs one after the other; variables that they write are given out in ascending order.
class Maker {
 public:
  explicit Maker(const Shape& shape) : dice_(shape.seed) { program_.shape = shape; }

  Program make() {
    const std::uint32_t rungs = program_.shape.rungs;
    program_.rungs.reserve(rungs);
    if (program_.shape.kind == Kind::kNested) {
      nested(rungs);
      return std::move(program_);
    }
    std::vector<Form> forms;
    std::uint32_t written[kTypes] = {};
    std::uint32_t rewritten = 0;
    for (std::uint32_t i = 0; i < rungs; ++i) {
      forms.push_back(form());
      if (forms.back() == Form::kRewritten) {
        ++rewritten;
        continue;
      }
      const Type type = type_of(forms.back());
      written[static_cast<std::size_t>(type)] += type == Type::kBool ? 1 : 2;
    }
    // An eighth of what is written again as inputs, where anything of that type is read.
    for (std::size_t t = 0; t < kTypes; ++t) {
      const bool read = written[t] != 0 || t == static_cast<std::size_t>(Type::kBool);
      program_.variables[t].inputs = read ? std::max(8u, std::max(written[t], rungs / 8) / 8) : 0;
      program_.variables[t].count = program_.variables[t].inputs + written[t];
      next_[t] = program_.variables[t].inputs;
    }
    if (rewritten != 0) share(rewritten);
    for (const Form form : forms) rung(form);
    return std::move(program_);
  }

 private:
  enum class Form : std::uint8_t { kPlain, kBlock, kDint, kReal, kRewritten, kTimer };
  static Type type_of(Form form) {
    return form == Form::kDint ? Type::kDint : form == Form::kReal ? Type::kReal : Type::kBool;
  }
  Form form() {
    const auto chain = [this] { return dice_.chance(50) ? Form::kReal : Form::kDint; };
    switch (program_.shape.kind) {
      case Kind::kBlocks:
        return Form::kBlock;
      case Kind::kArithmetic:
        return chain();
      case Kind::kMixed: {
        const std::uint32_t part = dice_.below(100);
        return part < 60 ? Form::kPlain : part < 80 ? Form::kBlock : chain();
      }
      case Kind::kRewritten:
        return Form::kRewritten;
      case Kind::kTimers:
        return Form::kTimer;
      case Kind::kMixed2: {
        const std::uint32_t part = dice_.below(100);
        return part < 60 ? Form::kRewritten : part < 80 ? Form::kTimer : chain();
      }
      case Kind::kPlain:
      case Kind::kNested:
        break;
    }
    return Form::kPlain;
  }

  [[nodiscard]] Variables& variables(Type type) { return program_.variables[static_cast<std::size_t>(type)]; }
  std::uint32_t next(Type type) { return next_[static_cast<std::size_t>(type)]++; }

  void rung(Form form) {
    if (type_of(form) != Type::kBool) {
      program_.rungs.emplace_back(chain(type_of(form)));
      return;
    }
    const auto [bools, inputs] = variables(Type::kBool);
    Rung rung;
    switch (form) {
      case Form::kRewritten: {
        rung.net = random_net(dice_, 4, dice_.chance(50), 1, {bools, inputs});
        const std::uint32_t kind = dice_.below(100);
        rung.coil = kind < 20 ? Coil::kSet : kind < 40 ? Coil::kReset : kind < 55 ? Coil::kNegated : Coil::kNormal;
        rung.target = targets_.back();
        targets_.pop_back();
        break;
      }
      case Form::kBlock:
      case Form::kTimer: {
        const Readable readable{bools, form == Form::kTimer ? inputs : 0};
        rung.net = random_net(dice_, 1 + dice_.below(3), dice_.chance(50), 1, readable);
        put_box(rung, static_cast<Box>(1 + dice_.below(kBoxes - 1)), bools);
        if (form == Form::kTimer) rung.preset = wide_preset(rung.box);
        rung.target = next(Type::kBool);
        break;
      }
      case Form::kPlain:
      case Form::kDint:
      case Form::kReal:
        rung.net = plain_net(dice_, {bools});
        rung.target = next(Type::kBool);
    }
    program_.rungs.emplace_back(std::move(rung));
  }

  /// Variables for rungs that write each other's: half as many as rungs, a quarter of them inputs. Each of the others
  /// is written by two to six rungs, in any order; what other rungs write comes after them.
  void share(std::uint32_t rungs) {
    constexpr std::uint32_t kFewest = 2, kMost = 6;
    const std::uint32_t all = std::max(16u, rungs / 2);
    const std::uint32_t outputs = std::min(all - all / 4, std::max(1u, rungs / kFewest));
    Variables& bools = variables(Type::kBool);
    bools.count += all - bools.inputs;
    bools.inputs = all - outputs;
    next_[static_cast<std::size_t>(Type::kBool)] = all;
    std::vector<std::uint32_t> writers(outputs);
    while (targets_.size() < rungs) {
      const auto turn = static_cast<std::uint32_t>(targets_.size());
      const std::uint32_t output = turn < kFewest * outputs ? turn % outputs : dice_.below(outputs);
      if (writers[output] == kMost) continue;
      ++writers[output];
      targets_.push_back(bools.inputs + output);
    }
    for (std::uint32_t i = rungs; i > 1; --i) std::swap(targets_[i - 1], targets_[dice_.below(i)]);
  }

  /// Timers: 2 to 255 scans of 20 ms, short ones as often as long ones.
  std::uint32_t wide_preset(Box box) {
    if (!is_timer(box)) return 1 + dice_.below(30);
    const std::uint32_t least = 2u << dice_.below(7);
    return 20 * (least + dice_.below(least));
  }

  void put_box(Rung& rung, Box box, std::uint32_t bools) {
    rung.box = box;
    rung.instance = program_.instances[static_cast<std::size_t>(box)]++;
    rung.preset = is_timer(box) ? 20 * (1 + dice_.below(50)) : 1 + dice_.below(9);
    rung.reset = dice_.below(bools);
  }

  /// Half as many variables as rungs, some of them latches that several rungs set and reset; the others have one normal
  /// or negated coil.
  void nested(std::uint32_t rungs) {
    Variables& bools = variables(Type::kBool);
    bools.count = std::max(16u, rungs / 2);
    bools.inputs = std::max(4u, bools.count / 16);
    const std::uint32_t outputs = bools.count - bools.inputs;
    const std::uint32_t latches = std::max(2u, outputs / 6);
    const std::uint32_t normals = outputs - latches;
    std::uint32_t next_normal = 0;
    for (std::uint32_t i = 0; i < rungs; ++i) {
      Rung rung;
      rung.net = random_net(dice_, 1 + dice_.below(kMaxContacts), false, kMaxNesting, {bools.count});
      const std::uint32_t kind = dice_.below(100);
      if (kind < 40 && next_normal < normals) {
        rung.coil = dice_.chance(20) ? Coil::kNegated : Coil::kNormal;
        rung.target = bools.inputs + next_normal++;
      } else {
        rung.coil = kind < 70 ? Coil::kSet : Coil::kReset;
        rung.target = bools.inputs + normals + dice_.below(latches);
      }
      constexpr Box kUsed[] = {Box::kTon, Box::kCtu, Box::kRTrig};
      if (dice_.chance(10)) put_box(rung, kUsed[dice_.below(3)], bools.count);
      program_.rungs.emplace_back(std::move(rung));
    }
  }

  /// Any variable but those that the chain itself writes.
  Operand variable(const Chain& chain) {
    const Variables& all = variables(chain.type);
    // WHY every other one an input: what chains make of each other's results settles at their limits.
    const std::uint32_t drawn = dice_.below(dice_.chance(50) ? all.inputs : all.count);
    return {{}, drawn == chain.kept || drawn == chain.target ? 0 : drawn};
  }
  Operand constant(Type type, std::uint32_t below) {
    const std::string whole = std::to_string(1 + dice_.below(below));
    return {type == Type::kDint ? whole : whole + (dice_.chance(50) ? ".5" : ".25"), 0};
  }

  /// Results of DINT wrap wherever they like. A REAL is multiplied by less than 1 only, and what is kept or written has
  /// limits, so that none becomes infinite.
  Chain chain(Type type) {
    constexpr std::size_t kFewest = 4, kMost = 8;
    Chain chain;
    chain.type = type;
    chain.kept = next(type);
    chain.target = next(type);
    chain.start = variable(chain);
    chain.links.resize(kFewest + dice_.below(kMost - kFewest + 1));
    chain.kept_at = chain.links.size() / 2 - 1;
    for (std::size_t i = 0; i < chain.links.size(); ++i) {
      const bool limited = i + 1 == chain.links.size() || (i == chain.kept_at && type == Type::kReal);
      chain.links[i] = link(limited ? Function::kLimit : static_cast<Function>(dice_.below(7)), chain);
    }
    return chain;
  }
  Link link(Function function, const Chain& chain) {
    Link link;
    link.function = function;
    if (function == Function::kLimit) {
      link.operand = constant(chain.type, 10'000);
      link.operand.constant.insert(0, 1, '-');
      link.maximum = constant(chain.type, 10'000);
    } else if (function == Function::kMul && chain.type == Type::kReal) {
      link.operand.constant = "0." + std::to_string(1 + dice_.below(999));
    } else {
      link.operand = dice_.chance(30) ? constant(chain.type, 100) : variable(chain);
    }
    if (function == Function::kSel) link.gate = dice_.below(variables(Type::kBool).count);
    return link;
  }

  Program program_;
  Dice dice_;
  std::uint32_t next_[kTypes] = {};
  std::vector<std::uint32_t> targets_;  ///< of the rungs that write each other's variables, the last one first
};

}  // namespace

std::string variable_name(Type type, std::uint32_t variable) {
  return "MDR"[static_cast<std::size_t>(type)] + std::to_string(variable);
}

std::string instance_name(Box box, std::uint32_t instance) {
  return kBoxNames[static_cast<std::size_t>(box)] + std::to_string(instance);
}

Program make_program(const Shape& shape) { return Maker(shape).make(); }

}  // namespace plc::bench
