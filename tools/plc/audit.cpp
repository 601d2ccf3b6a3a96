// plc audit: who did what on a plant, and whether anything of it was changed since.
#include "engineering/audit.h"

#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/command_line.h"
#include "tools/plc/commands.h"
#include "tools/statistics.h"

namespace plc::tools {
namespace {

struct AuditFlags {
  std::string file;
  bool json = false, check = false;
};

int run(const AuditFlags& flags) {
  const auto found = engineering::check_audit_file(flags.file);
  if (!found) return complain(found.error()), exit_code_of(found.error());
  if (flags.json) {
    for (const std::string& record : found->texts) std::cout << record << '\n';
  } else if (!flags.check) {
    std::vector<std::vector<std::string>> rows = {{"number", "time", "user", "address", "what", "details"}};
    for (const std::string& text : found->texts) {
      const auto record = nlohmann::ordered_json::parse(text, nullptr, false);
      const auto part = [&](const char* name) {
        return record.contains(name) && record[name].is_string() ? record[name].get<std::string>() : std::string();
      };
      rows.push_back({record["n"].dump(), part("time"), part("user"), part("address"), part("what"),
                      record.contains("details") ? record["details"].dump(-1, ' ', true) : ""});
    }
    print_table(rows, std::cout);
    std::cout << '\n';
  }
  if (!found->why.empty()) {
    std::cerr << fmt::format("{}:{}:1: error {}: {}\n  help: {} before it {} as written\n", flags.file,
                             found->broken_line, core::info(core::Code::P7702).name, found->why,
                             counted(found->texts.size(), "record"), found->texts.size() == 1 ? "is" : "are");
    return kExitErrors;
  }
  if (!flags.json)
    std::cout << fmt::format("{}, as written; the last one has the hash {}\n", counted(found->texts.size(), "record"),
                             found->hash);
  return kExitOk;
}

}  // namespace

void add_audit(Command program) {
  static AuditFlags flags;
  const Command command = program.sub("audit",
                                      "Shows who did what on a plant by its engineering server, and finds out whether "
                                      "a record was changed, taken out or "
                                      "put in since. plc-run may run meanwhile.\n"
                                      "\n"
                                      "Examples:\n"
                                      "  plc audit /var/lib/picard/plant/engineering   the records in a state folder\n"
                                      "  plc audit audit --check                       is it whole?");
  command.option("FILE", flags.file, "file \"audit\", or the folder with it").required();
  command.flag("--check", flags.check, "prints no records");
  command.flag("--json", flags.json, "the records alone, one JSON object a line");
  command.on_run([] { return run(flags); });
}

}  // namespace plc::tools
