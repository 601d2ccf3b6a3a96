// Handlers for POUs and bodies that both spellings (TC6 and IEC 61131-10) share.
//
// In: tags, while a pou or body is open in the Reader. Out: Project::pous. Does not belong here: drawn elements
// (reader_body.h), types and variables (reader_types.h).
#pragma once

#include "plcopen/reader_state.h"

namespace plc::plcopen {

/// <pou>
void start_pou(Reader& r, const Tag& tag);
/// Begins a POU named by the tag; close_pou() checks it and adds it to the project.
void open_pou(Reader& r, const Tag& tag, PouKind kind);
void close_pou(Reader& r);
/// An action of the open POU, or outside of all POUs; close_pou_action() adds it to its POU.
void start_pou_action(Reader& r, const Tag& tag);
void close_pou_action(Reader& r);
/// One step of the path in the project tree, by which an action outside of the POUs says where it belongs.
void path_structure(Reader& r, const Tag& tag);
/// Begins a body; close_body() checks it and adds it to the open POU.
void open_body(Reader& r, const Tag& tag);
void close_body(Reader& r);
void set_language(Reader& r, const Tag& tag, Language language);
/// P1016, once per POU with its actions.
void report_chart(Reader& r, const Tag& tag);
/// Begins the text of an ST or IL body that is open.
void begin_code(Reader& r, const Tag& tag);
/// Ends the text of an ST or IL body.
void end_code(Reader& r);
/// Duplicate ids, order of networks; moves the body of the innermost frame to its POU (reader_body.cpp).
void finish_body(Reader& r);

}  // namespace plc::plcopen
