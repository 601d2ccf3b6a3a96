#include "tests/engines/probes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <vector>

#include "bytecode/codegen/generate.h"
#include "compiler/compile.h"
#include "runtime/access.h"
#include "shadow/probe_view.h"
#include "tests/engines/instrument.h"
#include "tests/support/engines.h"
#include "tests/support/random_values.h"
#include "tests/support/replayed.h"

namespace plc::test {
namespace {

using bytecode::DrawnKey;
using bytecode::Image;
using bytecode::ProbePoint;
using bytecode::VerifiedImage;
using runtime::ProbedPou;

/// Words that begin an instruction or a look-up record, ascending.
std::vector<std::uint32_t> beginnings(const bytecode::ImagePou& pou) {
  std::vector<std::uint32_t> words;
  for (std::uint32_t at = 0; at < pou.code.size();) {
    const auto opcode = static_cast<bytecode::Opcode>(pou.code[at] & 0xffffu);
    const std::uint32_t items = pou.code[at] >> 16;
    words.push_back(at);
    for (std::uint32_t r = 1; opcode == bytecode::Opcode::kBoolRun && r < items; ++r) {
      words.push_back(at + 1 + r * bytecode::kRecordWords);
    }
    at += static_cast<std::uint32_t>(bytecode::words_of(bytecode::info(opcode).operands, items));
  }
  return words;
}

void plant(Image& image, PlantedFault fault) {
  for (std::size_t p = 0; p < image.probes.size(); ++p) {
    bytecode::PouProbes& map = image.probes[p];
    if (fault == PlantedFault::kOrder) {
      map.jumps.clear();
      for (bytecode::ProbeStep& step : map.steps) step.order = 0;
    }
    if (fault == PlantedFault::kLate) {
      const std::vector<std::uint32_t> words = beginnings(image.pous[p]);
      for (bytecode::ProbeStep& step : map.steps) {
        const auto next = std::upper_bound(words.begin(), words.end(), step.word);
        if (next != words.end()) step.word = *next;
      }
      std::stable_sort(map.steps.begin(), map.steps.end(), [](const auto& x, const auto& y) {
        return std::pair(x.word, x.order) < std::pair(y.word, y.order);
      });
    }
  }
}

DrawnKey key_of(const ir::ProbeKey& key) {
  return {0, key.local_id, key.line, key.column, key.pin, static_cast<bytecode::DrawnSide>(key.side)};
}

/// Whether instances of function blocks get the values of others, or begin anew: their stored values go with them.
bool copies_instances(const ir::Module& module) {
  return std::any_of(module.pous.begin(), module.pous.end(), [&](const ir::Pou& pou) {
    const bool temporary = std::any_of(pou.variables.begin(), pou.variables.end(), [&](const ir::Variable& v) {
      return v.in_frame && module.types.holds_instance(v.type);
    });
    return temporary || std::any_of(pou.body.insts.begin(), pou.body.insts.end(), [&](const ir::Inst& inst) {
             const bool writes = inst.op == ir::Op::kCopy || inst.op == ir::Op::kStore;
             return writes && module.types.holds_instance(pou.body.places[inst.a].type);
           });
  });
}

/// One POU on one instance, in the program with probes and in the one that stores.
struct Pair {
  const std::vector<Instrumented>* expected = nullptr;
  std::uint32_t pou = 0;        ///< of the image with probes
  ProbedPou view;               ///< in the program with probes
  std::uint32_t stored_at = 0;  ///< the instance, in the table of the program that stores
  std::uint32_t stored_type = 0;
  std::string path;
  std::map<std::string, std::uint32_t> offsets{};  ///< of stored variables, in the table
};

class Comparison {
 public:
  std::string run(const std::string& path, std::uint64_t seed, std::uint64_t scans, PlantedFault planted,
                  ProbeTally& tally) {
    compiler::Compilation compilation;
    compiler::Request request{path, {}, compiler::Goal::kModule};
    request.drawings = true;
    compiler::compile(request, compilation);
    if (!compilation.ok() || !compilation.module) return problem(compilation.diagnostics);
    ir::Module& module = *compilation.module;
    drawn_ = path.ends_with(".xml");
    // What tasks reach: the POUs of the image, in its order.
    auto image = make(module);
    module.probes = false;
    const auto without = make(module);
    module.probes = true;
    if (!image || !without) return problem(diagnostics_);
    if (!same_without_probes(*image, *without)) return "the image is another one without probes";
    plant(*image, planted);
    auto verified = bytecode::verify(std::move(*image), diagnostics_);
    if (!verified) return problem(diagnostics_);
    const auto expected = instrument(module);
    auto stored = make(module);
    if (!stored) return problem(diagnostics_);
    auto verified_stored = bytecode::verify(std::move(*stored), diagnostics_);
    if (!verified_stored) return problem(diagnostics_);
    return compare(std::move(*verified), std::move(*verified_stored), module, expected, seed, scans, tally);
  }

 private:
  std::optional<Image> make(const ir::Module& module) { return bytecode::generate(module, diagnostics_); }
  static std::string problem(const core::Diagnostics& diagnostics) {
    std::ostringstream text;
    diagnostics.render(text);
    return "refused: " + text.str();
  }
  static bool same_without_probes(Image with, const Image& without) {
    with.probes.clear();
    return bytecode::save(with) == bytecode::save(without);
  }

  std::string compare(VerifiedImage image, VerifiedImage stored, const ir::Module& module,
                      const std::vector<std::vector<Instrumented>>& expected, std::uint64_t seed, std::uint64_t scans,
                      ProbeTally& tally) {
    Random random(seed + (std::uint64_t{1} << 41));
    runtime::ProgramOptions options;
    if (drawn_) options.loop_budget = 300;  // loops of texts end
    std::string why;
    auto live = runtime::Resource::load(VerifiedImage(image), options);
    auto storing = runtime::Resource::load(std::move(stored), options);
    if (!live || !storing) return "not linked";
    const auto replayed = Replayed::make(image, **live, options, interpreter(), why);
    if (replayed == nullptr) return "no replica: " + why;
    const Image& code = image.image();
    find_pous(module, code);
    copies_instances_ = copies_instances(module);
    for (std::uint32_t t = 0; t < (*live)->task_count(); ++t) {
      std::string wrong = pair(code, expected, replayed->replica(t), (*storing)->program(t));
      if (!wrong.empty()) return wrong;
    }
    ++tally.programs;
    for (const bytecode::PouProbes& map : code.probes) tally.points += map.points.size();
    SharedInputs inputs(**live, **storing);
    core::TimeNs now_ns = 0;
    for (std::uint64_t scan = 0; scan < scans; ++scan) {
      if (scan > 0) inputs.change(random);
      const std::size_t turn = random.below((*live)->task_count());
      for (std::size_t n = 0; n < (*live)->task_count(); ++n) {
        const auto task = static_cast<std::uint32_t>((turn + n) % (*live)->task_count());
        clear(task, (*storing)->program(task));
        const runtime::Fault fault = execute(**live, task, now_ns);
        const runtime::Fault other = execute(**storing, task, now_ns);
        if (fault.kind != other.kind) return fmt::format("scan {}: another fault where values are stored", scan);
        for (const Pair& one : pairs_[task]) shadow::ProbeView(replayed->replica(task), one.view).clear();
        if (std::string wrong = replayed->check(task); !wrong.empty()) {
          return fmt::format("scan {}, executed with probes: {}", scan, wrong);
        }
        ++tally.scans;
        for (const Pair& one : pairs_[task]) {
          std::string wrong = check(one, replayed->replica(task), (*storing)->program(task), tally);
          if (!wrong.empty()) return fmt::format("scan {}, task {}, {}: {}", scan, task, one.path, wrong);
        }
      }
      now_ns += static_cast<core::TimeNs>(random.below(4)) * 10'000'000;
    }
    return {};
  }

  static runtime::Fault execute(runtime::Resource& resource, std::uint32_t task, core::TimeNs now_ns) {
    resource.process_image().sync();
    const runtime::Fault fault = resource.program(task).execute({now_ns, 0, now_ns});
    resource.process_image().sync();
    return fault;
  }

  /// Looks at all POUs on all instances of a task.
  std::string pair(const Image& code, const std::vector<std::vector<Instrumented>>& expected, runtime::Program& program,
                   runtime::Program& storing) {
    std::vector<ProbedPou> views;
    std::vector<Pair>& pairs = pairs_.emplace_back();
    for (std::uint32_t p = 0; p < code.pous.size(); ++p) {
      if (code.probes[p].empty()) continue;
      const auto mine = shadow::instances_of(program, p);
      const auto others = shadow::instances_of(storing, p);
      const std::uint32_t from = from_[p];
      for (const shadow::PouInstance& one : mine) {
        const auto other =
            std::find_if(others.begin(), others.end(), [&](const auto& o) { return o.path == one.path; });
        if (other == others.end()) return "no instance " + one.path + " where values are stored";
        Pair made;
        made.expected = &expected[from];
        made.pou = p;
        made.view = one.view;
        made.path = code.pous[p].name + " on " + one.path;
        const bool function = code.pous[p].kind == bytecode::PouKind::kFunction;
        // Globals that several tasks write are of none of them.
        if (function && code.tasks.size() > 1) continue;
        if (copies_instances_ && code.pous[p].kind == bytecode::PouKind::kFunctionBlock) continue;
        made.stored_at = function ? 0 : other->view.instance;
        const Image& image = storing.image();
        made.stored_type = function ? image.global_type : image.pous[p].instance_type;
        for (const bytecode::ImageField& field : image.types[made.stored_type].fields) {
          if (field.name.starts_with("#probe.")) made.offsets[field.name] = made.stored_at + field.offset;
        }
        views.push_back(one.view);
        pairs.push_back(std::move(made));
      }
    }
    const auto refused = program.look_at(views);
    return refused ? refused->message : std::string();
  }
  /// The POUs of the module that those of the image are made from: names of what is made from generic functions may
  /// occur several times.
  void find_pous(const ir::Module& module, const Image& code) {
    std::set<std::uint32_t> used;
    for (const bytecode::ImagePou& pou : code.pous) {
      std::uint32_t found = 0;
      while (found < module.pous.size() && (module.pous[found].name != pou.name || used.contains(found))) ++found;
      used.insert(found);
      from_.push_back(found);
    }
  }

  void clear(std::uint32_t task, runtime::Program& storing) {
    for (const Pair& one : pairs_[task]) {
      for (const auto& [name, offset] : one.offsets) {
        if (!name.ends_with(".value")) storing.table().data()[offset] = std::byte{0};
      }
    }
  }

  std::string check(const Pair& one, runtime::Program& program, runtime::Program& storing, ProbeTally& tally) {
    const shadow::ProbeView view(program, one.view);
    if (!view.any()) return "nothing is to be seen";
    for (const Instrumented& want : *one.expected) {
      const auto bit = [&](const std::string& name) {
        return storing.table().data()[one.offsets.at(name)] != std::byte{0};
      };
      const std::string where = fmt::format("element {}, line {}:{}, pin {}, side {}", want.key.local_id, want.key.line,
                                            want.key.column, want.key.pin, static_cast<int>(want.key.side));
      const auto shown = view.at(key_of(want.key));
      if (!shown) return where + " has no probe";
      if (shown->ran != bit(want.ran)) return where + (shown->ran ? " ran" : " did not run");
      if (!shown->ran) {
        ++tally.not_run;
        continue;
      }
      if (want.value.empty()) continue;
      if (!shown->known || shown->was_unknown) {
        ++tally.not_computed;
        continue;
      }
      ++tally.values;
      if (want.is_bool && (shown->was_on != bit(want.was_true) || shown->was_off != bit(want.was_false))) {
        return fmt::format("{} was {}{}, not {}{}", where, shown->was_off ? "FALSE " : "", shown->was_on ? "TRUE" : "",
                           bit(want.was_false) ? "FALSE " : "", bit(want.was_true) ? "TRUE" : "");
      }
      const std::string seen = view.text(key_of(want.key), runtime::ValueStyle::kNumbers);
      const std::string kept = stored_text(one, want, storing);
      if (seen != kept) return fmt::format("{} is {}, not {}", where, seen, kept);
    }
    return {};
  }
  std::string stored_text(const Pair& one, const Instrumented& want, runtime::Program& storing) {
    const Image& image = storing.image();
    const std::uint32_t offset = one.offsets.at(want.value);
    const auto leaf = bytecode::leaf_at(image, one.stored_type, offset - one.stored_at);
    const bytecode::ImageType& type = image.types[*leaf];
    std::vector<std::byte> value(storing.table().data() + offset, storing.table().data() + offset + type.size);
    if (type.kind == bytecode::TypeKind::kString) {
      // Of texts the beginning is taken.
      core::StringHeader head;
      std::memcpy(&head, value.data(), sizeof head);
      const std::uint32_t character = type.elementary == core::TypeId::kWstring ? 2 : 1;
      const auto most = static_cast<std::uint16_t>(bytecode::kProbedTextBytes / character);
      head.length = std::min(head.length, most);
      std::memcpy(value.data(), &head, sizeof head);
    }
    std::string text;
    runtime::append_value(type, value.data(), text, runtime::ValueStyle::kNumbers);
    return text;
  }

  /// Variables of both programs that get other values between scans.
  class SharedInputs {
   public:
    SharedInputs(runtime::Resource& one, runtime::Resource& other) : one_(one), other_(other) {
      const runtime::Access mine(one);
      const runtime::Access others(other);
      for (const runtime::Listed& listed : mine.list_places()) {
        // Inputs that are wired are where their wire comes from.
        const auto place = mine.find(listed.path);
        const auto other_place = others.find(listed.path);
        const bytecode::TypeKind kind = one.image().types[listed.place.type].kind;
        if (!place || !other_place || place->constant || kind == bytecode::TypeKind::kRef) continue;
        leaves_.push_back({*place, *other_place});
      }
    }
    void change(Random& random) {
      if (leaves_.empty()) return;
      std::vector<std::byte> value;
      constexpr std::size_t kMost = 500;  // a record holds no more
      for (std::size_t n = random.below(1 + std::min(leaves_.size() / 2, kMost)); n > 0; --n) {
        const Leaf& leaf = random.one_of(leaves_);
        const bytecode::ImageType& type = one_.image().types[leaf.one.type];
        value.assign(type.size, std::byte{});
        if (type.kind == bytecode::TypeKind::kString) {
          const core::StringHeader header{type.capacity, 0};
          std::memcpy(value.data(), &header, sizeof header);
        }
        random_value(type, random, value.data());
        write(one_, leaf.one, value);
        write(other_, leaf.other, value);
      }
    }

   private:
    struct Leaf {
      runtime::Place one, other;
    };
    static void write(runtime::Resource& resource, const runtime::Place& place, const std::vector<std::byte>& value) {
      if (place.task == runtime::Place::kGlobal) {
        const runtime::GlobalWrite one{place.offset, place.type, value.data()};
        resource.globals().write({&one, 1});
      } else {
        resource.program(place.task).write_local(place.offset, value);
      }
    }
    runtime::Resource& one_;
    runtime::Resource& other_;
    std::vector<Leaf> leaves_;
  };

  core::Diagnostics diagnostics_;
  std::vector<std::vector<Pair>> pairs_;  ///< by task
  bool copies_instances_ = false, drawn_ = false;
  std::vector<std::uint32_t> from_;  ///< by POU of the image: that of the module
};

}  // namespace

std::string compare_probes(const std::string& path, std::uint64_t seed, std::uint64_t scans, PlantedFault planted,
                           ProbeTally& tally) {
  return Comparison().run(path, seed, scans, planted, tally);
}

}  // namespace plc::test
