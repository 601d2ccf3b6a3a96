// plc explain: the execution order of drawn bodies, the data flow between tasks, whether they meet their deadlines, or
// the page of a problem code.
#include "frontend-sfc/explain.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "core/text.h"
#include "frontend-ld/lower.h"
#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/plc/commands.h"
#include "tools/plc/explain_drawing.h"
#include "tools/plc/explain_flow.h"
#include "tools/plc/explain_schedule.h"
#include "tools/problem_pages.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

struct Explain {
  std::string subject, pou, svg, configuration;
  bool flow = false, schedule = false, json = false;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

/// "P3007", "r1001": a letter and four digits.
bool is_code(const std::string& text) {
  if (text.size() != 5 || (core::upper(text[0]) != 'P' && core::upper(text[0]) != 'R')) return false;
  return std::all_of(text.begin() + 1, text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

int explain_code(const std::string& code) {
  for (const ProblemPage& page : problem_pages()) {
    if (core::iequals(page.code, code)) {
      std::cout << page.text;
      return kExitOk;
    }
  }
  complain("plc explain", "there is no problem code " + code, "codes are in the messages of plc check, like P4001");
  return kExitUsage;
}

std::string element_text(const core::SourceRef& at) {
  std::string text{core::element_word(at.kind)};
  if (at.local_id >= 0) text += fmt::format(" {}", at.local_id);
  return text;
}

std::string why_text(const ld::OrderLine& line) {
  std::string why{fbd::reason_text(line.reason)};
  if (line.with.kind != core::ElementKind::kNone) why += " " + element_text(line.with);
  if (!line.feedback_from.empty()) {
    why += "; value of the previous scan from";
    for (const std::int64_t id : line.feedback_from) why += fmt::format(" {}", id);
  }
  return why;
}

void print_body(const plcopen::Body& body, core::Order rule) {
  const std::vector<ld::OrderLine> lines = ld::explain_order(body, rule);
  std::size_t element_width = 0, text_width = 0;
  for (const ld::OrderLine& line : lines) {
    element_width = std::max(element_width, element_text(line.at).size());
    text_width = std::min<std::size_t>(40, std::max(text_width, line.text.size()));
  }
  std::uint32_t network = 0;
  std::size_t position = 0;
  for (const ld::OrderLine& line : lines) {
    if (line.network != network) {
      network = line.network;
      std::cout << fmt::format("  network {}\n", network);
    }
    std::cout << fmt::format("  {:>5}  {:<{}}  {:<{}}  line {:<6}  {}\n", ++position, element_text(line.at),
                             element_width, line.text, text_width, line.at.line, why_text(line));
  }
}

void print_bodies(const char* kind, const std::string& name, const std::vector<plcopen::Body>& bodies, core::Order rule,
                  bool final_scan) {
  for (const plcopen::Body& body : bodies) {
    std::cout << fmt::format("\n{} {} ({})\n", kind, name, plcopen::language_name(body.language));
    if (body.language == plcopen::Language::kLd || body.language == plcopen::Language::kFbd) {
      print_body(body, rule);
    } else if (body.language == plcopen::Language::kSfc) {
      for (const std::string& line : sfc::explain_chart(body, final_scan)) std::cout << line << '\n';
    } else if (body.language != plcopen::Language::kNone) {
      std::cout << "  executes as written: only drawings need an order\n";
    }
  }
}

int explain_file(const Explain& explain, const std::vector<std::string>& libraries) {
  Compilation compilation;
  if (is_image_path(explain.subject)) {
    complain("plc explain", explain.subject + " is an image: the order in it is that of its instructions",
             "give the file it was made from, or use plc dump; --svg draws what an image carries");
    return kExitUsage;
  }
  open({explain.subject, explain.options, Goal::kRead, libraries}, compilation);
  compilation.diagnostics.render_with_lines(std::cerr);
  if (!compilation.readable) return kExitUsage;
  if (!compilation.project) return kExitErrors;

  std::cout << fmt::format("order={}\n", explain.options.order == core::Order::kDrawing ? "drawing" : "document");
  const core::FinalScan asked = explain.options.sfc_final_scan;
  const bool final_scan =
      asked == core::FinalScan::kAuto ? compilation.project->has_3s_charts : asked == core::FinalScan::kOn;
  bool found = false;
  std::string names;
  for (const plcopen::Pou& pou : compilation.project->pous) {
    names += (names.empty() ? "" : ", ") + pou.name;
    const bool all = explain.pou.empty() || core::iequals(pou.name, explain.pou);
    if (all) print_bodies(plcopen::pou_kind_name(pou.kind), pou.name, pou.bodies, explain.options.order, final_scan);
    found = found || all;
    for (const plcopen::Pou& action : pou.actions) {
      const std::string name = pou.name + "." + action.name;
      if (!all && !core::iequals(name, explain.pou)) continue;
      found = true;
      print_bodies("action", name, action.bodies, explain.options.order, final_scan);
    }
  }
  if (!found && !explain.pou.empty()) {
    complain("plc explain", fmt::format("{} has no POU \"{}\"", explain.subject, explain.pou), "it has: " + names);
    return kExitErrors;
  }
  return compilation.ok() ? kExitOk : kExitErrors;
}

int run(Command command, const Explain& explain) {
  taskblocks::Registry registry;
  std::vector<std::string> libraries = explain.libraries;
  if (const auto code = load_taskblocks(explain.configuration, registry, libraries)) return *code;
  if (explain.flow) {
    return explain_flow(command, {explain.subject, explain.options, Goal::kRun, libraries, {}, &registry, true},
                        explain.svg);
  }
  if (explain.schedule) {
    return explain_schedule(
        command, {explain.subject, explain.configuration, explain.json, explain.options, libraries, &registry});
  }
  if (!explain.svg.empty()) {
    return explain_drawing(command, {explain.subject, explain.options, Goal::kRead, libraries}, explain.pou,
                           explain.svg);
  }
  if (is_code(explain.subject) && !std::filesystem::exists(explain.subject)) return explain_code(explain.subject);
  return explain_file(explain, libraries);
}

}  // namespace

void add_explain(Command program) {
  static Explain explain;
  const Command command = program.sub(
      "explain",
      "Prints the execution order of a project's drawings, with localIds and the reason for each place, or draws\n"
      "them; the data flow between its tasks; whether they meet their deadlines; or the page of a problem code.\n"
      "\n"
      "Examples:\n"
      "  plc explain plant.xml                    all POUs\n"
      "  plc explain plant.xml Main               one POU with its actions; Main.Start: one action\n"
      "  plc explain plant.xml --order=document   the order under the other rule\n"
      "  plc explain plant.xml Main --svg main.svg  a picture of a POU, whatever its language\n"
      "  plc explain plant.xml --flow             who writes and who reads each global, and how old values get\n"
      "  plc explain plant.pbc --flow --svg flow.svg\n"
      "  plc explain plant.xml --schedule         do all tasks end in time? estimated scans, response times, margins\n"
      "  plc explain plant.pbc --schedule --config plc.toml --json\n"
      "  plc explain P3007                        what a code means, with a wrong and a right example");
  command
      .option("SUBJECT", explain.subject,
              "PLCopen XML or ST file, source folder, or problem code; --svg, --flow, --schedule: or an image")
      .required();
  const Flag pou = command.option("POU", explain.pou, "only this POU");
  const Flag flow = command.flag("--flow", explain.flow, "the data flow between tasks, as tables").excludes({pou});
  const Flag svg = command.option("--svg=OUT", explain.svg,
                                  "draw the POUs, or with --flow the data flow, to this file instead; - is stdout");
  const Flag schedule =
      command.flag("--schedule", explain.schedule, "the tasks instead of the drawings").excludes({pou, flow, svg});
  command.option("--config=plc.toml", explain.configuration,
                 "[project] and [taskblocks] libraries that the project uses; with --schedule also priorities, "
                 "processors, deadlines and measured times of the tasks, and the calibration");
  command.flag("--json", explain.json, "the schedule as one JSON document").needs(schedule);
  add_library_option(command, explain.libraries);
  add_compile_options(command, explain.options, false);
  command.on_run([command] { return run(command, explain); });
}

}  // namespace plc::tools
