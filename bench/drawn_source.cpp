#include "bench/drawn_source.h"

#include <sstream>
#include <string>
#include <utility>

#include "bench/c_source.h"
#include "bench/drawing.h"
#include "bench/drawn_text.h"

namespace plc::bench {

Source make_source(const Shape& shape, Text text) {
  const Program program = make_program(shape);
  Source source;
  if (text == Text::kXml) {
    std::ostringstream xml;
    write_plcopen(program, xml);
    source.project = std::move(xml).str();
  } else {
    source.project = write_st(program);
    source.extension = "st";
  }
  source.c = write_c(program);
  const std::string in = std::string(kInstanceName) + '.';
  constexpr std::uint32_t kBytes[kTypes] = {1, 4, 4};
  constexpr Stimulus kStimuli[kTypes] = {Stimulus::kBool, Stimulus::kDint, Stimulus::kReal};
  for (const Type type : {Type::kBool, Type::kDint, Type::kReal}) {
    const auto t = static_cast<std::size_t>(type);
    for (std::uint32_t i = 0; i < program.variables[t].count; ++i) {
      source.variables.push_back({in + variable_name(type, i), c_variable(type, i), kBytes[t],
                                  i < program.variables[t].inputs ? kStimuli[t] : Stimulus::kNone});
    }
  }
  for (std::size_t b = 1; b < kBoxes; ++b) {
    const auto box = static_cast<Box>(b);
    for (std::uint32_t i = 0; i < program.instances[b]; ++i) {
      const std::string path = in + instance_name(box, i);
      const std::string c = c_instance(box, i);
      source.variables.push_back({path + ".Q", c + ".q", 1, Stimulus::kNone});
      if (is_timer(box)) source.variables.push_back({path + ".ET", c + ".et", 8, Stimulus::kNone});
      if (is_counter(box)) source.variables.push_back({path + ".CV", c + ".cv", 2, Stimulus::kNone});
    }
  }
  return source;
}

}  // namespace plc::bench
