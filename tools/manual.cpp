#include "tools/manual.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

namespace plc::tools {
namespace {

using Options = std::vector<const CLI::Option*>;

/// A text as roff takes it: no hyphen of typography, no line that looks like a request.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) {
      out += "\\&";
      out += c;
    } else {
      out += c;
    }
  }
  return out;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/// Those below that take files or flags themselves, with `app` if it has no commands.
void add_leaves(const CLI::App& app, std::vector<const CLI::App*>& leaves) {
  const auto commands = commands_of(app);
  if (commands.empty()) leaves.push_back(&app);
  for (const CLI::App* command : commands) add_leaves(*command, leaves);
}

Options options_of(const CLI::App& app, bool positional) {
  Options all =
      app.get_options([positional](const CLI::Option* option) { return option->get_positional() == positional; });
  std::erase_if(all,
                [](const CLI::Option* option) { return option->check_lname("help") || option->check_lname("manual"); });
  return all;
}

/// A description is a paragraph, then blocks that begin with "Examples:", "Exit codes: " or anything else.
std::string paragraphs(std::string_view text) {
  std::string out;
  bool literal = false;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    at = end + 1;
    const bool indented = line.starts_with("  ");
    if (indented != literal) out += indented ? ".PP\n.nf\n" : ".fi\n";
    literal = indented;
    if (line.empty()) {
      out += ".PP\n";
    } else {
      out += escaped(line) + "\n";
    }
  }
  return literal ? out + ".fi\n" : out;
}

std::string synopsis(const CLI::App& app) {
  std::string out = fmt::format(".B {}\n", escaped(full_name(app)));
  for (const CLI::Option* option : options_of(app, true)) {
    const std::string name = escaped(option->get_name(true));
    out += option->get_required() ? fmt::format(".I {}\n", name) : fmt::format(".RI [ {} ]\n", name);
  }
  for (const CLI::Option* option : options_of(app, false)) {
    if (option->get_required())
      out += fmt::format(".B {}\n.I {}\n", escaped(option->get_name()), escaped(option->get_type_name()));
  }
  return out + ".RI [ options ]\n.br\n";
}

std::string option_text(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  std::string out = fmt::format(".TP\n.B {}\n", escaped(option.get_name(option.get_positional(), true)));
  if (!type.empty())
    out = fmt::format(".TP\n.BI \"{} \" \"{}\"\n", escaped(option.get_name(false, true)), escaped(type));
  if (option.get_positional()) out = fmt::format(".TP\n.I {}\n", escaped(option.get_name(true)));
  return out + escaped(option.get_description()) + "\n";
}

std::string options_text(const Options& options) {
  std::string out;
  for (const CLI::Option* option : options) out += option_text(*option);
  return out;
}

}  // namespace

std::string manual_page(const CLI::App& app) {
  std::vector<const CLI::App*> leaves;
  add_leaves(app, leaves);
  const std::string description = app.get_description();
  std::string first = description.substr(0, description.find_first_of(":.\n"));
  first[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(first[0])));
  std::string out = fmt::format(
      ".\\\" Made by {0} \\-\\-manual.\n.TH {1} 1 \"\" \"PICARD\" \"User commands\"\n.SH NAME\n{0} \\- {2}\n.SH "
      "SYNOPSIS\n",
      escaped(app.get_name()), upper(escaped(app.get_name())), escaped(first));
  for (const CLI::App* leaf : leaves) out += synopsis(*leaf);
  out += ".SH DESCRIPTION\n" + paragraphs(description);
  // Flags that several commands have, in groups of their own, are said once.
  std::vector<std::string> groups;
  std::string shared;
  for (const CLI::App* leaf : leaves) {
    const bool is_app = leaf == &app;
    out += is_app ? ".SH OPTIONS\n"
                  : fmt::format(".SH {}\n", upper(escaped(full_name(*leaf)))) + paragraphs(leaf->get_description());
    out += options_text(options_of(*leaf, true));
    for (const CLI::Option* option : options_of(*leaf, false)) {
      const std::string& group = option->get_group();
      if (group == "Options") {
        out += option_text(*option);
      } else if (std::find(groups.begin(), groups.end(), group + option->get_name()) == groups.end()) {
        groups.push_back(group + option->get_name());
        if (shared.empty()) shared = fmt::format(".SH {}\n", upper(escaped(group)));
        shared += option_text(*option);
      }
    }
  }
  return out + shared + ".SH SEE ALSO\n.BR plc (1),\n.BR plc\\-run (1)\n";
}

std::string full_name(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name() : full_name(*app.get_parent()) + " " + app.get_name();
}

}  // namespace plc::tools
