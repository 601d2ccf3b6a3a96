// Handlers for drawn elements that both spellings (TC6 and IEC 61131-10) share.
//
// In: tags, while a body is open in the Reader. Out: Body::elements. Does not belong here: what a drawing means, wires
// by output point (iec61131_10_body.cpp).
#pragma once

#include "plcopen/reader_state.h"

namespace plc::plcopen {

/// Begins an element of `kind`; its place carries the localId. Returns it for further attributes.
Element& open_element(Reader& r, const Tag& tag, ElementKind kind, std::int64_t local_id);
/// Adds the open element to the body.
void close_element(Reader& r);
/// P1017 for an element of a drawing nobody knows; it counts as drawn.
void unknown_element(Reader& r, const Tag& tag);

/// What the open action of the open action block refers to.
void name_action(Reader& r, std::string name);

void element_position(Reader& r, const Tag& tag);
/// A connection point in or out directly under the element: a pin of its own.
void own_point_in(Reader& r, const Tag& tag);
void own_point_out(Reader& r, const Tag& tag);
void pin_point_in(Reader& r, const Tag& tag);
void pin_point_out(Reader& r, const Tag& tag);
void close_pin(Reader& r);
void point_expression(Reader& r);
void point_target(Reader& r);
/// A closed branch of CODESYS, in a frame of its own while it is read.
void start_closed_branch(Reader& r, const Tag& tag);
void end_closed_branch(Reader& r);
void start_branch_input(Reader& r, const Tag& tag);
void start_branch_line(Reader& r, const Tag& tag);
/// Adds a wire to the open pin.
Connection& add_connection(Reader& r, const Tag& tag);
void element_code(Reader& r);

}  // namespace plc::plcopen
