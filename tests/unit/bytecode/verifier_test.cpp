// Every rule of bytecode/rules.def refuses an image that breaks it, and nothing else refuses the sample.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "bytecode/rules.h"
#include "tests/support/sample_image.h"

namespace plc::test {
namespace {

using bytecode::Rule;
using bytecode::verify;

struct Case {
  Rule rule;
  std::string what;
  std::function<void(Sample&)> spoil;
};

/// Operand word `n` of the `nth` instruction with this opcode.
Word& operand(Sample& s, std::uint32_t pou, Opcode opcode, std::size_t n, std::size_t nth = 0) {
  ImagePou& p = s.image.pous[pou];
  return p.code[find_op(p, opcode, nth) + 1 + n];
}
std::uint32_t body(const Sample& s) { return s.image.tasks[0].body; }
/// Into the body of the task, before the `nth` instruction with the opcode `before`.
void insert(Sample& s, Opcode before, std::initializer_list<Word> words, std::size_t nth = 0) {
  ImagePou& p = s.image.pous[body(s)];
  p.code.insert(p.code.begin() + static_cast<std::ptrdiff_t>(find_op(p, before, nth)), words);
}
constexpr Word kLock = bytecode::opcode_word(Opcode::kLock), kUnlock = bytecode::opcode_word(Opcode::kUnlock),
               kRaise = bytecode::opcode_word(Opcode::kRaisePriority),
               kReschedule = bytecode::opcode_word(Opcode::kReschedule);
void put(std::vector<std::byte>& bytes, Word at, const std::vector<std::byte>& value) {
  std::memcpy(bytes.data() + bytecode::offset_of(at), value.data(), value.size());
}
std::vector<bytecode::ImageAlias>& aliases(Sample& s) {
  return s.image.types[s.image.pous[s.motor].instance_type].aliases;
}
/// The probe map of Main.
bytecode::PouProbes& probes(Sample& s) {
  if (s.image.probes.empty()) add_sample_probes(s);
  return s.image.probes[s.main];
}
/// A chain of functions, each calling the next `times` times.
Image chain(std::uint32_t length, std::uint32_t times) {
  ImageBuilder b;
  std::uint32_t next = 0;
  for (std::uint32_t i = 0; i < length; ++i) {
    PouBuilder f = b.pou("F" + std::to_string(i), PouKind::kFunction);
    if (i != 0) {
      for (std::uint32_t n = 0; n < times; ++n) f.op(Opcode::kCallFn, {next});
    }
    next = f.finish();
  }
  PouBuilder p = b.pou("P", PouKind::kProgram);
  p.op(Opcode::kCallFn, {next});
  b.task("T", 0, {p.finish()});
  return b.build();
}

const std::vector<Case>& cases() {
  static const std::vector<Case> kCases = {
      {Rule::kV101, "an array of itself", [](Sample& s) { s.image.types[s.line].element = s.line; }},
      {Rule::kV101, "a reference to nowhere",
       [](Sample& s) {
         for (ImageType& t : s.image.types) {
           if (t.kind == TypeKind::kRef) t.element = 1000;
         }
       }},
      {Rule::kV102, "an INT of four bytes", [](Sample& s) { s.image.types[s.integer].size = 4; }},
      {Rule::kV102, "a STRING as a scalar", [](Sample& s) { s.image.types[s.integer].elementary = TypeId::kString; }},
      {Rule::kV103, "a string aligned to 3", [](Sample& s) { s.image.types[s.label].align = 3; }},
      {Rule::kV103, "a string too small for its characters", [](Sample& s) { s.image.types[s.label].capacity = 40; }},
      {Rule::kV104, "an array larger than its elements", [](Sample& s) { ++s.image.types[s.line].count; }},
      {Rule::kV104, "an array whose upper bound is no number",
       [](Sample& s) { s.image.types[s.line].lower = std::numeric_limits<std::int64_t>::max(); }},
      {Rule::kV105, "a reference of four bytes",
       [](Sample& s) {
         for (ImageType& t : s.image.types) {
           if (t.kind == TypeKind::kRef) t.size = 4;
         }
       }},
      {Rule::kV106, "arrays of arrays of arrays",
       [](Sample& s) {
         for (int i = 0; i < 70; ++i) {
           ImageType t = s.image.types[s.line];
           t.element = i == 0 ? s.dint : static_cast<std::uint32_t>(s.image.types.size() - 1);
           t.count = 1;
           t.size = 4;
           s.image.types.push_back(t);
         }
       }},
      {Rule::kV107, "two fields at one place", [](Sample& s) { s.image.types[s.point].fields[1].offset = 0; }},
      {Rule::kV107, "a field past the end", [](Sample& s) { s.image.types[s.point].fields[1].offset = 8; }},
      {Rule::kV107, "bytes without fields", [](Sample& s) { s.image.types[s.point].fields.clear(); }},
      {Rule::kV108, "a structure aligned to 3", [](Sample& s) { s.image.types[s.point].align = 3; }},
      {Rule::kV108, "a field at an odd place",
       [](Sample& s) {
         s.image.types[s.point].size = 12;
         s.image.types[s.point].fields[1].offset = 5;
       }},
      {Rule::kV109, "an array of a gigabyte",
       [](Sample& s) {
         ImageType t = s.image.types[s.line];
         t.count = 0x10000001u;
         t.size = t.count * 4;
         s.image.types.push_back(t);
       }},
      {Rule::kV110, "limits the wrong way round", [](Sample& s) { s.image.types[s.colour].upper = 0; }},
      {Rule::kV110, "limits on a REAL",
       [](Sample& s) {
         s.image.types[s.real].limited = true;
         s.image.types[s.real].upper = 1;
       }},
      {Rule::kV111, "members without values", [](Sample& s) { s.image.types[s.colour].member_values.pop_back(); }},
      {Rule::kV111, "a member outside the limits", [](Sample& s) { s.image.types[s.colour].member_values[0] = 0; }},
      {Rule::kV112, "a field without a name", [](Sample& s) { s.image.types[s.point].fields[0].name.clear(); }},
      {Rule::kV112, "a name that would clear the terminal", [](Sample& s) { s.image.types[s.point].name = "\x1b[2J"; }},
      {Rule::kV113, "a scalar with elements", [](Sample& s) { s.image.types[s.integer].count = 1; }},
      {Rule::kV113, "an array with an alias", [](Sample& s) { s.image.types[s.line].aliases = {{"a", 0}}; }},
      {Rule::kV114, "an alias of no global", [](Sample& s) { aliases(s)[0].global = 10; }},
      {Rule::kV114, "an alias without a name", [](Sample& s) { aliases(s)[0].name.clear(); }},
      {Rule::kV114, "an alias that rings the bell", [](Sample& s) { aliases(s)[0].name = "\a"; }},
      {Rule::kV114, "an alias called like a field", [](Sample& s) { aliases(s)[0].name = "RUN"; }},
      {Rule::kV115, "a constant that is kept",
       [](Sample& s) {
         ImageField& field = s.image.types[s.image.pous[s.motor].instance_type].fields[0];
         field.retain = field.constant = true;
       }},
      {Rule::kV115, "a field that is kept and begins anew",
       [](Sample& s) {
         ImageField& field = s.image.types[s.image.pous[s.motor].instance_type].fields[0];
         field.persistent = field.fresh = true;
       }},
      {Rule::kV114, "two aliases of one name", [](Sample& s) { aliases(s).push_back({"Sensor", 0}); }},

      {Rule::kV201, "a number as global table", [](Sample& s) { s.image.global_type = s.integer; }},
      {Rule::kV201, "a frame of no type", [](Sample& s) { s.image.pous[s.main].frame_type = 9999; }},
      {Rule::kV202, "a byte missing", [](Sample& s) { s.image.global_initial.pop_back(); }},
      {Rule::kV203, "a BOOL of 2", [](Sample& s) { put(s.image.global_initial, s.go, bytes_of(std::uint8_t{2})); }},
      {Rule::kV204, "a capacity beyond the value",
       [](Sample& s) {
         put(s.image.global_initial, s.title, bytes_of(core::StringHeader{500, 0}));
       }},
      {Rule::kV204, "a length beyond the capacity",
       [](Sample& s) {
         put(s.image.global_initial, s.title, bytes_of(core::StringHeader{20, 21}));
       }},
      {Rule::kV205, "a forged reference",
       [](Sample& s) { put(s.image.pous[s.main].instance_initial, s.line_ref, bytes_of(std::uint64_t{8})); }},
      {Rule::kV206, "a colour that is none",
       [](Sample& s) {
         for (const ImageField& f : s.image.types[s.image.global_type].fields) {
           if (f.name == "colour") put(s.image.global_initial, f.offset, bytes_of(std::int16_t{9}));
         }
       }},
      {Rule::kV207, "a NaN with a payload",
       [](Sample& s) { put(s.image.global_initial, s.gain, bytes_of(std::uint32_t{0x7fc00001})); }},
      {Rule::kV208, "a field without a global", [](Sample& s) { s.image.globals.pop_back(); }},
      {Rule::kV209, "a thousand tasks of five megabytes",
       [](Sample& s) {
         ImageBuilder b;
         b.global("big", b.array(b.type(TypeId::kLint), 655'360));
         PouBuilder p = b.pou("P", PouKind::kProgram);
         b.task("T", 0, {p.finish()});
         s.image = b.build();
         s.image.tasks.resize(1000, s.image.tasks[0]);
       }},
      {Rule::kV210, "a function that remembers",
       [](Sample& s) {
         s.image.pous[s.max2].instance_type = s.point;
         s.image.pous[s.max2].instance_initial.resize(8);
       }},

      {Rule::kV301, "an unknown opcode", [](Sample& s) { s.image.pous[s.main].code[0] = 0xfff0; }},
      {Rule::kV302, "an instruction without its operands",
       [](Sample& s) { s.image.pous[s.main].code.back() = bytecode::opcode_word(Opcode::kMove16); }},
      {Rule::kV302, "a list without its items",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.main];
         p.code[find_op(p, Opcode::kCallFn)] = bytecode::opcode_word(Opcode::kCallFn, 60000);
       }},
      {Rule::kV303, "code that runs off the end", [](Sample& s) { s.image.pous[s.main].code.pop_back(); }},
      {Rule::kV303, "no code", [](Sample& s) { s.image.pous[s.motor].code.clear(); }},
      {Rule::kV304, "a jump into an instruction", [](Sample& s) { ++operand(s, s.max2, Opcode::kCondJump, 1); }},
      {Rule::kV304, "a jump past the end", [](Sample& s) { operand(s, s.max2, Opcode::kCondJump, 1) = 100000; }},
      {Rule::kV305, "a jump back that nothing counts", [](Sample& s) { operand(s, s.max2, Opcode::kCondJump, 1) = 0; }},
      {Rule::kV305, "a counted jump forward",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.main];
         operand(s, s.main, Opcode::kLoopJump, 0) = static_cast<Word>(p.code.size() - 1);
       }},
      {Rule::kV306, "a RETURN with a list",
       [](Sample& s) { s.image.pous[s.main].code.back() = bytecode::opcode_word(Opcode::kReturn, 1); }},
      {Rule::kV306, "a run of nothing",
       [](Sample& s) { s.image.pous[s.main].code.back() = bytecode::opcode_word(Opcode::kBoolRun, 0); }},
      {Rule::kV307, "an operand between two variables", [](Sample& s) { ++operand(s, s.main, Opcode::kAdd16, 1); }},
      {Rule::kV307, "an operand of another width", [](Sample& s) { operand(s, s.main, Opcode::kAdd16, 1) = s.total; }},
      {Rule::kV307, "an operand past the table",
       [](Sample& s) { operand(s, s.main, Opcode::kAdd16, 1) = 0x3fffffff; }},
      {Rule::kV307, "a run over a number", [](Sample& s) { operand(s, s.motor, Opcode::kBoolRun, 3) = s.level; }},
      {Rule::kV308, "a timer where none is", [](Sample& s) { operand(s, s.motor, Opcode::kRunTb, 1) = s.level; }},
      {Rule::kV308, "a copy of another type", [](Sample& s) { operand(s, s.main, Opcode::kCopy, 2) = s.point; }},
      {Rule::kV309, "a new value for a literal", [](Sample& s) { operand(s, s.main, Opcode::kAdd16, 0) = s.one; }},
      {Rule::kV309, "a new value for a constant", [](Sample& s) { operand(s, s.main, Opcode::kAdd16, 0) = s.limit; }},
      {Rule::kV310, "a block that is not there", [](Sample& s) { operand(s, s.motor, Opcode::kRunTb, 0) = 99; }},
      {Rule::kV310, "a type that is not there", [](Sample& s) { operand(s, s.main, Opcode::kCopy, 2) = 9999; }},
      {Rule::kV310, "a POU that is not there", [](Sample& s) { operand(s, s.main, Opcode::kCallPou, 0) = 9999; }},
      {Rule::kV310, "a function that is not there", [](Sample& s) { operand(s, s.main, Opcode::kCallStd, 0) = 9999; }},
      {Rule::kV311, "a function that looks into an instance",
       [](Sample& s) { operand(s, s.max2, Opcode::kMove32, 1) = bytecode::operand_word(Space::kInstance, 0); }},
      {Rule::kV312, "debug entries the wrong way round", [](Sample& s) { s.image.pous[s.main].debug[0].word = 5; }},
      {Rule::kV312, "a debug entry past the code", [](Sample& s) { s.image.pous[s.main].debug[1].word = 100000; }},
      {Rule::kV312, "a file that is not there", [](Sample& s) { s.image.files.clear(); }},
      {Rule::kV313, "a reference to a line moved to one to a motor",
       [](Sample& s) {
         operand(s, s.main, Opcode::kMoveRef, 0) = s.line_ref;
         operand(s, s.main, Opcode::kMoveRef, 1) = s.motor_ref;
       }},
      {Rule::kV313, "a call of something else",
       [](Sample& s) { operand(s, s.main, Opcode::kCallVia, 1) = s.line_ref; }},
      {Rule::kV313, "a path from another type", [](Sample& s) { operand(s, s.main, Opcode::kRefVia, 2) = s.grid; }},
      {Rule::kV313, "a reference to something else than the path's end",
       [](Sample& s) { operand(s, s.main, Opcode::kRefAt, 0) = s.motor_ref; }},
      {Rule::kV313, "a run of something that is no timer",
       [](Sample& s) { operand(s, s.main, Opcode::kRunAt, 6) = 0; }},
      {Rule::kV314, "a reference to a literal",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.max2];
         Word& offset = s.image.types[p.frame_type].fields[3].offset;
         p.code.insert(p.code.begin(), {bytecode::opcode_word(Opcode::kRefAt),
                                        bytecode::operand_word(Space::kFrame, offset), s.one, s.integer});
       }},

      {Rule::kV315, "bit 16 of an INT", [](Sample& s) { operand(s, s.main, Opcode::kExtract, 2) = 16; }},
      {Rule::kV315, "a bit of an INT put into a DINT", [](Sample& s) { operand(s, s.main, Opcode::kInsert, 0) = s.total; }},

      {Rule::kV316, "a step of no kind", [](Sample& s) { operand(s, s.main, Opcode::kLoadAt, 3) = 3; }},
      {Rule::kV316, "a field of an array", [](Sample& s) { operand(s, s.main, Opcode::kLoadAt, 3) = 0; }},
      {Rule::kV316, "an index into a structure", [](Sample& s) { operand(s, s.main, Opcode::kLoadAt, 5) = 2; }},
      {Rule::kV316, "an element of a structure", [](Sample& s) { operand(s, s.main, Opcode::kLoadAt, 5) = 1; }},
      {Rule::kV316, "a field that is not there", [](Sample& s) { operand(s, s.main, Opcode::kLoadAt, 6) = 2; }},
      {Rule::kV316, "the element after the last", [](Sample& s) { operand(s, s.main, Opcode::kStoreAt, 4) = 3; }},
      {Rule::kV316, "a path that continues after a number",
       [](Sample& s) { operand(s, s.main, Opcode::kLoadAt, 2) = s.line; }},
      {Rule::kV316, "the element after the last of what a reference refers to",
       [](Sample& s) { operand(s, s.main, Opcode::kLoadVia, 4) = 4; }},
      {Rule::kV307, "a BOOL as index", [](Sample& s) { operand(s, s.main, Opcode::kLoadAt, 4) = s.go; }},
      {Rule::kV307, "a REAL as index", [](Sample& s) { operand(s, s.main, Opcode::kRefVia, 4) = s.gain; }},
      {Rule::kV307, "half a number as index", [](Sample& s) { ++operand(s, s.main, Opcode::kLoadAt, 4); }},
      {Rule::kV308, "a path from the middle of an array", [](Sample& s) { operand(s, s.main, Opcode::kLoadAt, 1) += 8; }},
      {Rule::kV308, "a path from another place",
       [](Sample& s) { operand(s, s.main, Opcode::kStoreAt, 0) = bytecode::operand_word(Space::kInstance, 0); }},
      {Rule::kV309, "a path that writes into the constants",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.main];
         p.code.insert(p.code.end() - 1, {bytecode::opcode_word(Opcode::kStoreAt), s.one, s.level, s.integer});
       }},
      {Rule::kV309, "a path that writes a constant field",
       [](Sample& s) { s.image.types[s.point].fields[0].constant = true; }},
      {Rule::kV309, "a value read into a literal", [](Sample& s) { operand(s, s.main, Opcode::kLoadAt, 0) = s.one; }},
      {Rule::kV317, "a DINT read into an INT", [](Sample& s) { operand(s, s.main, Opcode::kLoadVia, 0) = s.level; }},
      {Rule::kV317, "an INT stored in a DINT", [](Sample& s) { operand(s, s.main, Opcode::kStoreAt, 1) = s.level; }},
      {Rule::kV317, "a REAL stored through a reference to a DINT",
       [](Sample& s) { operand(s, s.max2, Opcode::kStoreVia, 1) = s.gain; }},
      {Rule::kV317, "a whole structure read into a number",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.main];
         const std::size_t at = find_op(p, Opcode::kLoadAt);
         p.code[at] = bytecode::opcode_word(Opcode::kLoadAt, 1);
         p.code.erase(p.code.begin() + static_cast<std::ptrdiff_t>(at) + 6,
                      p.code.begin() + static_cast<std::ptrdiff_t>(at) + 8);
         operand(s, s.main, Opcode::kCondJump, 1) -= 2;
         operand(s, s.main, Opcode::kLoopJump, 0) -= 2;
       }},

      {Rule::kV401, "a function called as a function block",
       [](Sample& s) { operand(s, s.main, Opcode::kCallPou, 0) = s.max2; }},
      {Rule::kV401, "a function block called as a function",
       [](Sample& s) { operand(s, s.main, Opcode::kCallFn, 0) = s.motor; }},
      {Rule::kV403, "a parameter that is not there", [](Sample& s) { operand(s, s.main, Opcode::kCallFn, 1) = 99; }},
      {Rule::kV403, "a hidden variable as parameter", [](Sample& s) { operand(s, s.main, Opcode::kCallFn, 1) = 6; }},
      {Rule::kV404, "an INT for a DINT", [](Sample& s) { operand(s, s.main, Opcode::kCallFn, 2) = s.level; }},
      {Rule::kV404, "a reference to something else",
       [](Sample& s) { operand(s, s.main, Opcode::kCallFn, 8) = s.line_ref; }},
      {Rule::kV404, "a number for a structure", [](Sample& s) { operand(s, s.main, Opcode::kCallFn, 10) = s.total; }},
      {Rule::kV405, "a function that calls itself",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.max2];
         p.code.insert(p.code.end() - 1, {bytecode::opcode_word(Opcode::kCallFn), s.max2});
       }},
      {Rule::kV406, "a chain of 70 calls", [](Sample& s) { s.image = chain(70, 1); }},
      {Rule::kV407, "two to the power of 40 calls", [](Sample& s) { s.image = chain(40, 2); }},
      {Rule::kV408, "a program that imports",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.main];
         p.code.insert(p.code.end() - 1, {bytecode::opcode_word(Opcode::kReadN), 0, 1});
         p.debug.clear();
       }},
      {Rule::kV408, "a program that raises its priority",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.main];
         p.code.insert(p.code.end() - 1, {bytecode::opcode_word(Opcode::kRaisePriority), 0, 1});
         p.debug.clear();
       }},
      {Rule::kV408, "a program that takes the lock",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.main];
         p.code.insert(p.code.end() - 1, bytecode::opcode_word(Opcode::kLock));
         p.debug.clear();
       }},
      {Rule::kV408, "a program that gives the lock back",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.main];
         p.code.insert(p.code.end() - 1, bytecode::opcode_word(Opcode::kUnlock));
         p.debug.clear();
       }},
      {Rule::kV408, "a function that reschedules",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.max2];
         p.code.insert(p.code.end() - 1, bytecode::opcode_word(Opcode::kReschedule));
         p.debug.clear();
       }},
      {Rule::kV409, "globals after the last", [](Sample& s) { operand(s, body(s), Opcode::kReadN, 1) = 1000; }},
      {Rule::kV409, "a range that wraps", [](Sample& s) { operand(s, body(s), Opcode::kReadN, 0) = 0xffffffffu; }},
      {Rule::kV410, "an exported constant",
       [](Sample& s) {
         operand(s, body(s), Opcode::kWriteN, 1) = 3;
         s.image.globals[2].writers = 1;
       }},
      {Rule::kV411, "a writer too many", [](Sample& s) { ++s.image.globals[0].writers; }},
      {Rule::kV412, "a program as task", [](Sample& s) { s.image.tasks[0].body = s.main; }},
      {Rule::kV412, "a task without a body", [](Sample& s) { s.image.tasks[0].body = 9999; }},
      {Rule::kV413, "a negative period", [](Sample& s) { s.image.tasks[0].period_ns = -1; }},
      {Rule::kV413, "a task without a name", [](Sample& s) { s.image.tasks[0].name.clear(); }},
      {Rule::kV414, "released by a number", [](Sample& s) { s.image.tasks[0].single = "level"; }},
      {Rule::kV414, "released by nothing", [](Sample& s) { s.image.tasks[0].single = "nobody"; }},
      {Rule::kV415, "1025 tasks", [](Sample& s) { s.image.tasks.resize(1025, s.image.tasks[0]); }},
      {Rule::kV416, "a program under the lock",
       [](Sample& s) {
         insert(s, Opcode::kReadN, {kLock});
         insert(s, Opcode::kReturn, {kUnlock});
       }},
      {Rule::kV416, "a program at raised priority",
       [](Sample& s) {
         insert(s, Opcode::kReadN, {kRaise, 0, 1});
         insert(s, Opcode::kReturn, {kReschedule});
       }},
      {Rule::kV416, "a program at the priority that a copy took",
       [](Sample& s) {
         s.image.options.coherence = core::Coherence::kPriorityCeiling;
         insert(s, Opcode::kReturn, {kReschedule});
       }},
      {Rule::kV416, "the same after a lock",
       [](Sample& s) {
         s.image.options.coherence = core::Coherence::kPriorityCeiling;
         insert(s, Opcode::kReadN, {kLock});
         insert(s, Opcode::kCallPou, {kUnlock});
         insert(s, Opcode::kReturn, {kReschedule});
       }},
      {Rule::kV416, "a jump under the lock",
       [](Sample& s) {
         insert(s, Opcode::kReadN, {kLock, bytecode::opcode_word(Opcode::kLoopJump), 0, kUnlock});
       }},
      {Rule::kV416, "a return under the lock", [](Sample& s) { insert(s, Opcode::kReturn, {kLock}); }},
      {Rule::kV416, "a return at raised priority", [](Sample& s) { insert(s, Opcode::kReturn, {kRaise, 0, 1}); }},
      {Rule::kV416, "the lock taken twice", [](Sample& s) { insert(s, Opcode::kReadN, {kLock, kLock, kUnlock}); }},
      {Rule::kV416, "the lock given back twice", [](Sample& s) { insert(s, Opcode::kReadN, {kLock, kUnlock, kUnlock}); }},
      {Rule::kV416, "the lock taken at raised priority",
       [](Sample& s) {
         insert(s, Opcode::kReadN, {kRaise, 0, 1, kLock, kUnlock, kReschedule});
       }},
      {Rule::kV416, "a priority raised under the lock",
       [](Sample& s) {
         insert(s, Opcode::kReadN, {kLock, kRaise, 0, 1, kUnlock, kReschedule});
       }},
      {Rule::kV416, "a priority taken back under the lock",
       [](Sample& s) { insert(s, Opcode::kReadN, {kLock, kReschedule, kUnlock}); }},

      {Rule::kV417, "a queue without its writer", [](Sample& s) { s.image.queues[0].puts.clear(); }},
      {Rule::kV417, "a queue without its reader",
       [](Sample& s) { s.image.queues[0].takes = bytecode::ImageQueue::kNoTask; }},
      {Rule::kV417, "a queue of two readers",
       [](Sample& s) {
         s.image.tasks.push_back(s.image.tasks[0]);
         for (auto& global : s.image.globals) global.writers *= 2;
         s.image.queues[0].puts = {0, 1};
       }},
      {Rule::kV211, "a queue without room", [](Sample& s) { s.image.queues[0].capacity = 0; }},
      {Rule::kV211, "a queue of nothing", [](Sample& s) { s.image.queues[0].type = 9999; }},
      {Rule::kV211, "a queue larger than a table", [](Sample& s) { s.image.queues[0].capacity = 0x10000000; }},
      {Rule::kV211, "a queue with a ring too many", [](Sample& s) { s.image.queues[0].puts = {0, 0}; }},
      {Rule::kV211, "a queue of no task", [](Sample& s) { s.image.queues[0].takes = 7; }},
      {Rule::kV318, "an unknown queue", [](Sample& s) { operand(s, s.main, Opcode::kQueueCount, 1) = 1; }},
      {Rule::kV318, "a queue of other elements", [](Sample& s) { s.image.queues[0].type = s.integer; }},
      {Rule::kV508, "a queue port of what is no taskblock",
       [](Sample& s) { s.image.pous[s.main].queue_ports.push_back({0, "IN", 0, true}); }},

      {Rule::kV319, "a probe map too few", [](Sample& s) { probes(s), s.image.probes.pop_back(); }},
      {Rule::kV320, "a step inside of an instruction", [](Sample& s) { probes(s).steps[0].word = 1; }},
      {Rule::kV320, "a step behind the code", [](Sample& s) { probes(s).steps.back().word = 100000; }},
      {Rule::kV320, "steps in another order", [](Sample& s) { std::swap(probes(s).steps[3], probes(s).steps[8]); }},
      {Rule::kV320, "orders that descend", [](Sample& s) { probes(s).steps[11].order = 2; }},
      {Rule::kV321, "a capture of another type", [](Sample& s) { probes(s).steps[0].a = s.total; }},
      {Rule::kV321, "a capture behind the table",
       [](Sample& s) { probes(s).steps[0].a = bytecode::operand_word(Space::kGlobal, 100000); }},
      {Rule::kV321, "a capture inside of a value", [](Sample& s) { ++probes(s).steps[0].a; }},
      {Rule::kV321, "a capture of a type that does not exist", [](Sample& s) { probes(s).steps[0].type = 100000; }},
      {Rule::kV321, "a capture of a reference",
       [](Sample& s) {
         bytecode::ProbeStep& step = probes(s).steps[0];
         step.a = s.line_ref;
         step.type = *bytecode::leaf_at(s.image, s.image.pous[s.main].instance_type, bytecode::offset_of(s.line_ref));
       }},
      {Rule::kV321, "a capture in the instance of a function",
       [](Sample& s) {
         probes(s);
         s.image.probes[s.max2].steps = {
             {0, 0, bytecode::ProbeOp::kCapture, bytecode::operand_word(Space::kInstance, 0), 0, s.dint,
              bytecode::kNoStep}};
       }},
      {Rule::kV321, "a constant text", [](Sample& s) { probes(s).steps[7].type = s.label; }},
      {Rule::kV321, "a place with a type", [](Sample& s) { probes(s).steps[5].type = s.integer; }},
      {Rule::kV322, "an operand that comes later", [](Sample& s) { probes(s).steps[4].b = 4; }},
      {Rule::kV322, "an operand that is no BOOL", [](Sample& s) { probes(s).steps[2].a = 0; }},
      {Rule::kV322, "an operand without a value", [](Sample& s) { probes(s).steps[10].b = 5; }},
      {Rule::kV322, "a condition that is no BOOL", [](Sample& s) { probes(s).steps[5].when = 0; }},
      {Rule::kV323, "a jump where none is", [](Sample& s) { probes(s).jumps[0].word = 0; }},
      {Rule::kV323, "a jump twice", [](Sample& s) { probes(s).jumps.push_back(probes(s).jumps[0]); }},
      {Rule::kV323, "a point of no step", [](Sample& s) { probes(s).points[0].step = 1000; }},
      {Rule::kV323, "a point twice", [](Sample& s) { probes(s).points[1].key = probes(s).points[0].key; }},

      {Rule::kV501, "an unknown block", [](Sample& s) { s.image.blocks[0].name = "NOPE"; }},
      {Rule::kV502, "another layout", [](Sample& s) { s.image.blocks[0].layout_hash ^= 1; }},
      {Rule::kV503, "other ports", [](Sample& s) { s.image.types[s.image.blocks[0].type].fields[0].name = "OTHER"; }},
      {Rule::kV503, "a block of no type", [](Sample& s) { s.image.blocks[0].type = 9999; }},
      {Rule::kV504, "an unknown function", [](Sample& s) { s.image.functions[0] = "NOPE:INT"; }},
      {Rule::kV507, "a wire to what is no taskblock",
       [](Sample& s) { s.image.pous[s.main].wires.push_back({0, 0, 0}); }},
      {Rule::kV505, "an argument missing",
       [](Sample& s) {
         ImagePou& p = s.image.pous[s.main];
         const std::size_t at = find_op(p, Opcode::kCallStd);
         p.code[at] = bytecode::opcode_word(Opcode::kCallStd, 2);
         p.code.erase(p.code.begin() + static_cast<std::ptrdiff_t>(at) + 3);
         operand(s, s.main, Opcode::kCondJump, 1) -= 1;
         operand(s, s.main, Opcode::kLoopJump, 0) -= 1;
       }},
      {Rule::kV506, "a DINT for an INT", [](Sample& s) { operand(s, s.main, Opcode::kCallStd, 2) = s.total; }},
  };
  return kCases;
}

std::string render(const core::Diagnostics& diagnostics) {
  std::ostringstream out;
  diagnostics.render(out);
  return out.str();
}

TEST(Verifier, AcceptsTheSample) {
  core::Diagnostics diagnostics;
  const auto verified = verify(sample_image().image, diagnostics);
  ASSERT_TRUE(verified) << render(diagnostics);
  EXPECT_EQ(verified->call_depth(), 2u);  // task, Main, Motor or Max2
  EXPECT_TRUE(diagnostics.all().empty());
}

TEST(Verifier, AcceptsTheSampleWithProbes) {
  Sample s = sample_image();
  add_sample_probes(s);
  core::Diagnostics diagnostics;
  EXPECT_TRUE(verify(std::move(s.image), diagnostics)) << render(diagnostics);
}

TEST(Verifier, EveryBrokenRuleIsFoundAndNamed) {
  for (const Case& c : cases()) {
    Sample s = sample_image();
    c.spoil(s);
    core::Diagnostics diagnostics;
    EXPECT_FALSE(verify(std::move(s.image), diagnostics)) << c.what;
    const bytecode::RuleInfo& rule = bytecode::info(c.rule);
    bool named = false;
    for (const core::Diagnostic& d : diagnostics.all()) {
      named =
          named || (d.code == rule.code && d.message.find("(rule " + std::string(rule.id) + ": ") != std::string::npos);
    }
    EXPECT_TRUE(named) << c.what << " should break " << rule.id << ", found:\n" << render(diagnostics);
  }
}

TEST(Verifier, SectionsAroundCopiesAreFine) {
  for (const core::Coherence coherence :
       {core::Coherence::kWaitFree, core::Coherence::kPriorityCeiling, core::Coherence::kGlobalLock}) {
    Sample s = sample_image();
    s.image.options.coherence = coherence;
    // Raised again on the way, and taken back where nothing was raised.
    insert(s, Opcode::kReadN, {kReschedule, kRaise, 0, 1, kRaise, 0, 2});
    insert(s, Opcode::kCallPou, {kReschedule, kLock, bytecode::opcode_word(Opcode::kReadN), 2, 1, kUnlock});
    insert(s, Opcode::kReturn, {kReschedule});
    core::Diagnostics diagnostics;
    EXPECT_TRUE(verify(std::move(s.image), diagnostics)) << render(diagnostics);
  }
}

TEST(Verifier, EveryRuleHasACase) {
  std::set<std::string_view> covered;
  for (const Case& c : cases()) covered.insert(bytecode::info(c.rule).id);
  for (const bytecode::RuleInfo& rule : bytecode::rules()) EXPECT_EQ(covered.count(rule.id), 1u) << rule.id;
}

TEST(Verifier, ABrokenRuleInCodeNamesTheDrawnElement) {
  Sample s = sample_image();
  operand(s, s.main, Opcode::kAdd16, 1) = s.total;
  core::Diagnostics diagnostics;
  ASSERT_FALSE(verify(std::move(s.image), diagnostics));
  EXPECT_EQ(diagnostics.all()[0].pou, "Main");
  EXPECT_EQ(diagnostics.all()[0].at.local_id, 10'000'000'001);
}

TEST(Verifier, AnImageThatBreaksEveryRuleEverywhereIsReportedShortly) {
  ImageBuilder b;
  for (int i = 0; i < 1000; ++i) b.global("b", b.boolean(), bytes_of(std::uint8_t{7}));
  core::Diagnostics diagnostics;
  EXPECT_FALSE(verify(b.build(), diagnostics));
  EXPECT_LE(diagnostics.all().size(), bytecode::kMaxReports);
}

TEST(Verifier, MixesSignsOfAWidthButNotWidths) {
  ImageBuilder b;
  const Word i = b.global("i", b.type(TypeId::kInt));
  const Word w = b.global("w", b.type(TypeId::kWord));
  PouBuilder p = b.pou("P", PouKind::kProgram);
  p.op(Opcode::kMove16, {i, w}).op(Opcode::kAdd16, {w, i, i});
  b.task("T", 0, {p.finish()});
  core::Diagnostics diagnostics;
  EXPECT_TRUE(verify(b.build(), diagnostics)) << render(diagnostics);
}

TEST(Verifier, InstancesWithoutVariablesAreFine) {
  ImageBuilder b;
  std::vector<std::uint32_t> programs;
  for (int i = 0; i < 3; ++i) programs.push_back(b.pou("P" + std::to_string(i), PouKind::kProgram).finish());
  b.task("T", 0, programs);
  core::Diagnostics diagnostics;
  EXPECT_TRUE(verify(b.build(), diagnostics)) << render(diagnostics);
}

TEST(Verifier, ArgumentsOfFunctionsMayBeStringsOfAnyCapacity) {
  ImageBuilder b;
  PouBuilder f = b.pou("F", PouKind::kFunction);
  f.frame("text", b.string(80), FieldRole::kInput);
  const std::uint32_t callee = f.finish();
  PouBuilder p = b.pou("P", PouKind::kProgram);
  p.list(Opcode::kCallFn, 1, {callee, 0, b.text("short")});
  b.task("T", 0, {p.finish()});
  core::Diagnostics diagnostics;
  EXPECT_TRUE(verify(b.build(), diagnostics)) << render(diagnostics);
}

}  // namespace
}  // namespace plc::test
