// Functions that no row can be, because they are of variables and wires and not of values: the front ends know them by
// name.
//
// Listed here for people: plc lib, the pages, guesses at mistyped names. Does not belong here: what they do
// (ir/generic.h, frontend-st, frontend-fbd).
#pragma once

#include <span>
#include <string_view>

namespace plc::stdlib {

struct SpecialSpec {
  std::string_view name;
  std::string_view signature;  ///< as people read it
  std::string_view summary;
  std::string_view clause;
  std::string_view example;  ///< an ST statement, or as drawn
  bool drawn_only = false;   ///< a block of drawings, from IN to OUT of one type; texts have no need of it
};
inline constexpr SpecialSpec kSpecials[] = {
    {"LOWER_BOUND", "LOWER_BOUND(ARR: any array, DIM: ANY_INT) : DINT",
     "The least index of an array in dimension DIM, counted from 1. A computed DIM that does not exist is an event.",
     "IEC 61131-3:2013, table 15", "FOR i := LOWER_BOUND(values, 1) TO UPPER_BOUND(values, 1) DO .. END_FOR;"},
    {"UPPER_BOUND", "UPPER_BOUND(ARR: any array, DIM: ANY_INT) : DINT",
     "The greatest index of an array in dimension DIM, counted from 1. A computed DIM that does not exist is an event.",
     "IEC 61131-3:2013, table 15", "FOR i := LOWER_BOUND(values, 1) TO UPPER_BOUND(values, 1) DO .. END_FOR;"},
    {"REF", "REF(a variable) : REF_TO its type", "A reference to the variable.", "IEC 61131-3:2013, table 12",
     "r := REF(level);"},
    {"ADR", "ADR(a variable) : REF_TO its type", "REF under the name that CODESYS and TwinCAT have for it.",
     "not in the standard; as in CODESYS", "r := ADR(level);"},
    {"SIZEOF", "SIZEOF(a variable or type) : integer",
     "Its bytes as CODESYS lays it out on a 64-bit machine, as a literal: BOOL 1, INT 2, TIME 4, STRING[n] n + 1; "
     "members of structures begin at multiples of their size.",
     "not in the standard; as in CODESYS", "FOR i := 0 TO SIZEOF(buffer) / SIZEOF(buffer[0]) - 1 DO .. END_FOR;"},
    {"TIME", "TIME() : TIME", "The time since the PLC started. It stands still within a cycle.",
     "not in the standard; as in CODESYS", "elapsed := TIME() - begun;"},
    {"LTIME", "LTIME() : LTIME", "The time since the PLC started. It stands still within a cycle.",
     "not in the standard; as in CODESYS", "elapsed := LTIME() - begun;"},
    {"UTC_DT", "UTC_DT() : DT",
     "The date and time of the machine in UTC. It stands still within a cycle, and jumps when that clock is set.",
     "not in the standard; PICARD's own", "stamp := UTC_DT();"},
    {"UTC_LDT", "UTC_LDT() : LDT", "The same as LDT.", "not in the standard; PICARD's own", "stamp := UTC_LDT();"},
    {"LOCAL_DT", "LOCAL_DT() : DT",
     "The date and time of the machine in the time zone of the plant. Once a year an hour comes twice: for what people "
     "read, not for differences.",
     "not in the standard; PICARD's own", "shown := LOCAL_DT();"},
    {"LOCAL_LDT", "LOCAL_LDT() : LDT", "The same as LDT.", "not in the standard; PICARD's own",
     "shown := LOCAL_LDT();"},
    {"QUEUE_PUT", "QUEUE_PUT(QUEUE: a global array, IN: its element) : BOOL",
     "Puts an element into a queue; FALSE when it is full. The array is the queue: as many elements as it has, for "
     "each task that puts.",
     "PICARD; paper, 3.1", "accepted := QUEUE_PUT(orders, order);"},
    {"QUEUE_GET", "QUEUE_GET(QUEUE: a global array, OUT => its element) : BOOL",
     "Takes the oldest element out of a queue, of one task after the other; FALSE, and OUT zero, when there is none. "
     "One task takes.",
     "PICARD; paper, 3.1", "WHILE QUEUE_GET(orders, OUT => order) DO .. END_WHILE;"},
    {"QUEUE_COUNT", "QUEUE_COUNT(QUEUE: a global array) : UDINT", "Elements in a queue.", "PICARD; paper, 3.1",
     "waiting := QUEUE_COUNT(orders);"},
    {"QUEUE_SPACE", "QUEUE_SPACE(QUEUE: a global array) : UDINT", "Elements that this task may still put into a queue.",
     "PICARD; paper, 3.1", "IF QUEUE_SPACE(orders) >= 3 THEN .. END_IF;"},
    {"DELAY", "DELAY(IN: ANY) : ANY",
     "What entered in the scan before, of any type: opens every loop through it. First 0, FALSE or empty. A FALSE EN "
     "lets nothing enter; OUT is what entered last.",
     "not in the standard; PICARD's own", "level --[DELAY]-- level_before", true},
};
constexpr std::span<const SpecialSpec> specials() { return kSpecials; }
/// Pins of those that are drawn only.
inline constexpr std::string_view kDrawnInput = "IN";
inline constexpr std::string_view kDrawnOutput = "OUT";
/// What people read above their list.
inline constexpr std::string_view kSpecialsTitle = "Of variables and wires";

}  // namespace plc::stdlib
