// Every overload as users reach it: a call in ST with variables and with constants, and a drawn block. Compiled by the
// whole pipeline and run; results are those of the kernel, bit for bit, and ENO tells its events.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "tests/library/project.h"
#include "tests/library/values.h"

namespace plc::test {
namespace {

/// One call in a program, and the arguments it is made with.
struct Call {
  const Overload* overload = nullptr;
  std::size_t count = 0;  ///< of arguments
  std::vector<Arguments> lists{};
};
constexpr std::size_t kCallsPerProgram = 300;
constexpr std::size_t kScans = 200;
constexpr std::size_t kConstantLists = 20;

/// Every overload; extensible ones with one argument more than declared, too.
const std::vector<Call>& calls() {
  static const std::vector<Call> kCalls = [] {
    std::vector<Call> out;
    for (const Overload& overload : stdlib::overloads()) {
      const std::size_t declared = overload.spec->param_count;
      for (std::size_t count = declared; count <= declared + (overload.spec->extensible ? 1u : 0u); ++count) {
        out.push_back({&overload, count, argument_lists(overload, count, kScans)});
      }
    }
    return out;
  }();
  return kCalls;
}

std::string type_of(TypeId type) { return std::string(core::name_of(type)); }
std::string input(std::size_t call, std::size_t i) { return fmt::format("a{}_{}", call, i); }
std::string result(std::size_t call) { return fmt::format("r{}", call); }
std::string eno(std::size_t call) { return fmt::format("e{}", call); }
std::string in_program(std::size_t call, const std::string& name) {
  return fmt::format("p{}.{}", call / kCallsPerProgram, name);
}

/// What callers write: outputs of a bundle are taken by name from the bundle.
std::string name_of(const Overload& overload) {
  const std::string_view name = overload.name;
  return std::string(name.substr(0, name.find('.')));
}
std::string output_pin(const Overload& overload) {
  return stdlib::is_bundle_output(*overload.spec) ? std::string(stdlib::output_name(*overload.spec)) : "OUT";
}
std::string statement(const Overload& overload, const std::string& result, const std::vector<std::string>& arguments) {
  if (stdlib::is_bundle_output(*overload.spec)) {
    return fmt::format("{}({}, {} => {});", name_of(overload), arguments[0], output_pin(overload), result);
  }
  return fmt::format("{} := {}({});", result, name_of(overload), fmt::join(arguments, ", "));
}

ProgramText& program_of(std::vector<ProgramText>& programs, std::size_t call) {
  if (programs.size() <= call / kCallsPerProgram) programs.emplace_back();
  return programs[call / kCallsPerProgram];
}
/// Declares what the calls read and write.
std::vector<ProgramText> with_variables() {
  std::vector<ProgramText> programs;
  for (std::size_t k = 0; k < calls().size(); ++k) {
    const Call& call = calls()[k];
    ProgramText& program = program_of(programs, k);
    for (std::size_t i = 0; i < call.count; ++i) {
      program.variables.push_back({input(k, i), type_of(call.overload->param_type(i))});
    }
    program.variables.push_back({result(k), type_of(call.overload->result_type())});
  }
  return programs;
}

/// Room in which no result of the samples is cut: whether ENO tells of an event is asked of the call alone, and what a
/// variable cannot take belongs to the assignment after it.
constexpr std::uint16_t kAmpleRoom = 1000;

/// Sets the inputs of all calls, scans, and compares; `with_eno` where ENO is drawn too.
void run(Project& project, bool with_eno) {
  std::cout << fmt::format("{} calls of {} overloads, {} scans in each of {} engines\n", calls().size(),
                           stdlib::overloads().size(), kScans, project.engines());
  std::size_t wrong = 0;
  for (std::size_t scan = 0; scan < kScans && wrong < 20; ++scan) {
    for (std::size_t k = 0; k < calls().size(); ++k) {
      const Arguments& list = calls()[k].lists[scan % calls()[k].lists.size()];
      for (std::size_t i = 0; i < list.size(); ++i) project.write(in_program(k, input(k, i)), list[i]->value);
    }
    ASSERT_EQ(project.scan(static_cast<core::TimeNs>(scan) * 10'000'000), "") << "scan " << scan;
    for (std::size_t k = 0; k < calls().size(); ++k) {
      const Overload& overload = *calls()[k].overload;
      const std::vector<Value> arguments = values_of(calls()[k].lists[scan % calls()[k].lists.size()]);
      const Outcome kernel = call_kernel(overload, arguments);
      const Value got = project.read(in_program(k, result(k)), overload.result_type());
      if (got != kernel.result) {
        ++wrong;
        ADD_FAILURE() << stdlib::key_of(overload) << shown(arguments) << " = " << shown(got) << ", the kernel gives "
                      << shown(kernel.result);
      }
      if (!with_eno) continue;
      const bool fine = call_kernel(overload, arguments, kAmpleRoom).event == Event::kNone;
      if ((project.read(in_program(k, eno(k)), TypeId::kBool).bits != 0) != fine) {
        ++wrong;
        ADD_FAILURE() << "ENO of " << stdlib::key_of(overload) << shown(arguments) << " is " << !fine;
      }
    }
  }
}

TEST(Programs, EveryOverloadIsCalledInStructuredText) {
  std::vector<ProgramText> programs = with_variables();
  for (std::size_t k = 0; k < calls().size(); ++k) {
    std::vector<std::string> arguments;
    for (std::size_t i = 0; i < calls()[k].count; ++i) arguments.push_back(input(k, i));
    program_of(programs, k).statements.push_back(statement(*calls()[k].overload, result(k), arguments));
  }
  Project project("calls.st", structured_text(programs));
  ASSERT_EQ(project.problem(), "");
  run(project, false);
}

TEST(Programs, EveryOverloadIsDrawnAsABlock) {
  std::vector<ProgramText> programs = with_variables();
  for (std::size_t k = 0; k < calls().size(); ++k) {
    ProgramText& program = program_of(programs, k);
    program.variables.push_back({eno(k), "BOOL"});
    DrawnBlock block;
    block.type = name_of(*calls()[k].overload);
    for (std::size_t i = 0; i < calls()[k].count; ++i) {
      block.inputs.push_back({stdlib::pin_name(*calls()[k].overload->spec, i), input(k, i)});
    }
    block.outputs = {{output_pin(*calls()[k].overload), result(k)}, {"ENO", eno(k)}};
    program.blocks.push_back(std::move(block));
  }
  Project project("blocks.xml", plcopen_xml(programs));
  ASSERT_EQ(project.problem(), "");
  run(project, true);
}

// Exact functions of constants are computed by the compiler, the others and those with an event when the program runs.
TEST(Programs, ConstantsGiveWhatVariablesGive) {
  struct Case {
    std::size_t call;
    const Arguments* arguments;
  };
  std::vector<Case> cases;
  std::vector<ProgramText> programs;
  for (std::size_t k = 0; k < calls().size(); ++k) {
    const std::vector<Arguments>& lists = calls()[k].lists;
    const std::size_t step = std::max<std::size_t>(1, lists.size() / kConstantLists);
    for (std::size_t i = 0; i < lists.size(); i += step) {
      const bool written =
          std::all_of(lists[i].begin(), lists[i].end(), [](const Sample* sample) { return !sample->st.empty(); });
      if (!written) continue;
      std::vector<std::string> arguments;
      for (const Sample* sample : lists[i]) arguments.push_back(sample->st);
      ProgramText& program = program_of(programs, cases.size());
      program.variables.push_back({result(cases.size()), type_of(calls()[k].overload->result_type())});
      program.statements.push_back(statement(*calls()[k].overload, result(cases.size()), arguments));
      cases.push_back({k, &lists[i]});
    }
  }
  Project project("constants.st", structured_text(programs));
  ASSERT_EQ(project.problem(), "");
  ASSERT_EQ(project.scan(0), "");
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Overload& overload = *calls()[cases[i].call].overload;
    const std::vector<Value> arguments = values_of(*cases[i].arguments);
    EXPECT_EQ(shown(project.read(in_program(i, result(i)), overload.result_type())),
              shown(call_kernel(overload, arguments).result))
        << stdlib::key_of(overload) << shown(arguments);
  }
}

}  // namespace
}  // namespace plc::test
