// Ports of what a block stands for: which declared input, output or in-out a drawn pin means.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ir/builder.h"
#include "plcopen/project.h"

namespace plc::fbd {

struct Port {
  std::string_view name;
  std::string_view alias;  ///< second name seen in exports, or empty
  stdlib::Direction direction = stdlib::Direction::kInput;
  std::uint32_t index = 0;  ///< field of the instance, or variable of the POU
  ir::TypeRef type{};       ///< for in-outs the type referred to
  bool queue = false;       ///< an in-out that names a queue
  bool result = false;      ///< the output that is the value of a function
  bool constant = false;    ///< an in-out that is only read (VAR_IN_OUT CONSTANT)
};

/// Inputs, outputs and in-outs of an instance type (standard block or POU), in declared order.
std::vector<Port> ports_of(const ir::Module& module, ir::TypeRef type);
/// The same of a function POU; the result is the first output.
std::vector<Port> ports_of_function(const ir::Module& module, const ir::Pou& pou);

/// The same of a standard function of several outputs; `index` counts its outputs.
std::vector<Port> ports_of_bundle(const stdlib::BundleSpec& bundle);

/// Whether a drawn pin has the name or the alias of `port`, in any letter case.
bool is_named(const Port& port, std::string_view pin);

/// The port a drawn pin means: by name or alias, case-insensitive; OUT, where nothing is called so, the result of a
/// function; else the `position`-th of that direction. Null when there is none.
const Port* find_port(const std::vector<Port>& ports, stdlib::Direction direction, std::string_view pin,
                      std::size_t position);

/// EN or ENO that a POU declares itself: filled from the wires EN and ENO of a block, and not counted among the pins.
/// Null when it has none.
const Port* declared_enable(const std::vector<Port>& ports);
const Port* declared_eno(const std::vector<Port>& ports);

/// Position of an output pin among the drawn outputs, ENO and in-outs drawn again not counted.
std::size_t output_position(const plcopen::Element& block, std::size_t pin);

/// Position of an input pin among the drawn inputs, EN not counted.
std::size_t input_position(const plcopen::Element& block, const plcopen::Pin& pin);

/// A box that names an action, or a program: what it runs on.
struct NamedCall {
  std::string instance;                       ///< path of the instance; empty = that of the body
  std::uint32_t action = ir::Pou::kDeclared;  ///< into Module::pous; kDeclared = the program's own body
  ir::TypeRef type{};                         ///< of the instance
};
/// "Start", "pump.Start", "Pump.Start" with the instance above it, "Program.Start", "Program"; nothing for other boxes
/// (no report).
std::optional<NamedCall> named_call(ir::Builder& builder, const plcopen::Element& block);

/// Ports of the action, program, POU, standard block or function of several outputs that a block stands for by its
/// name; nothing for others.
std::optional<std::vector<Port>> ports_of_block(ir::Builder& builder, const plcopen::Element& block);

/// All outputs and in-outs that a block has by its type, the result of a function included; nothing when the type is
/// not known.
std::optional<std::vector<Port>> outputs_of(ir::Builder& builder, const plcopen::Element& block);

/// `name` without the namespace of a library before it ("Standard.TON"), where only what is left is known; the function
/// that a symbol (">=") stands for.
std::string_view type_name(ir::Builder& builder, std::string_view name);

/// Declared type of an input pin of a drawn function block, function POU or standard function of several outputs;
/// nothing for others (no report).
std::optional<ir::TypeRef> type_of_pin(ir::Builder& builder, const plcopen::Element& block, const plcopen::Pin& pin);

/// What output `pin` of a drawn block begins with by its declaration in the project, when it has type `type`; empty =
/// the default of the type.
std::vector<ir::InitItem> initial_of_output(ir::Builder& builder, const plcopen::Element& block, std::size_t pin,
                                            ir::TypeRef type);

/// The memory of output `pin` of a drawn function block instance that is a variable of the POU; nothing for others,
/// functions and unknown blocks (no report).
std::optional<ir::PlaceId> instance_output(ir::Builder& builder, const plcopen::Element& block, std::size_t pin);

}  // namespace plc::fbd
