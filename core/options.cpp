#include "core/options.h"

#include <algorithm>

namespace plc::core {

std::string wrong_define(const std::string& text) {
  const std::string name = text.substr(0, text.find('='));
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_part = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); };
  const bool good = !name.empty() && is_letter(name[0]) && std::all_of(name.begin(), name.end(), is_part);
  return good ? std::string()
              : "\"" + name + "\" is no name: a letter or underscore, then letters, digits, underscores";
}

}  // namespace plc::core
