// A small image that uses every part of the format: all kinds of types, tables and POUs, and every group of
// instructions. Tests break it, save it, list it and mutate it.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "bytecode/drawings.h"
#include "tests/support/image_builder.h"

namespace plc::test {

struct Sample {
  Image image;
  std::uint32_t boolean = 0, integer = 0, dint = 0, lint = 0, real = 0, colour = 0, line = 0, point = 0, label = 0,
                grid = 0, motors = 0;                                 // types
  std::uint32_t max2 = 0, motor = 0, main = 0;                        // POUs
  Word go = 0, level = 0, limit = 0, total = 0, title = 0, gain = 0;  // globals
  Word one = 0;                                                       // constant
  Word line_ref = 0, motor_ref = 0;                                   // Main
};

inline Sample sample_image() {
  Sample s;
  ImageBuilder b;
  b.image.files = {"sample.xml"};
  s.boolean = b.boolean();
  s.integer = b.type(TypeId::kInt);
  s.dint = b.type(TypeId::kDint);
  s.lint = b.type(TypeId::kLint);
  s.real = b.type(TypeId::kReal);
  s.colour = b.limited(TypeId::kInt, 1, 3, "Colour");
  b.image.types[s.colour].members = {"Red", "Green", "Blue"};
  b.image.types[s.colour].member_values = {1, 2, 3};
  s.line = b.array(s.dint, 4, 1);
  s.point = b.structure("Point", {{"x", s.dint}, {"y", s.dint}});
  s.label = b.string(20);
  const std::uint32_t wide = b.string(6, TypeId::kWstring);
  const std::uint32_t dint_ref = b.ref(s.dint);

  s.go = b.global("go", s.boolean);
  s.level = b.global("level", s.integer, bytes_of(std::int16_t{-7}));
  s.limit = b.global("limit", s.integer, bytes_of(std::int16_t{100}), {.constant = true});
  b.global("sensor", s.boolean, {}, {.input = true, .list = "IO", .address = "%IX0.0"});
  s.total = b.global("total", s.dint);
  s.title = b.global("title", s.label);
  b.global("wide", wide);
  b.global("colour", s.colour);
  s.gain = b.global("gain", s.real, bytes_of(std::numeric_limits<float>::quiet_NaN()));
  b.global("sum", b.type(TypeId::kLreal), bytes_of(0.1));
  s.one = b.constant<std::int16_t>(TypeId::kInt, 1);
  const Word name = b.text("say \"hi\"; \\ \n");

  PouBuilder max2 = b.pou("Max2", PouKind::kFunction);
  const Word a = max2.frame("a", s.dint, FieldRole::kInput);
  const Word c = max2.frame("c", s.dint, FieldRole::kInput);
  const Word result = max2.frame("Max2", s.dint, FieldRole::kReturnValue);
  const Word at = max2.frame("at", dint_ref, FieldRole::kInOut);
  max2.frame("where", s.point, FieldRole::kInput);
  max2.frame("text", s.label, FieldRole::kInput);
  const Word less = max2.frame("t#0", s.boolean, FieldRole::kHidden);
  max2.op(Opcode::kMove32, {result, a});
  max2.op(Opcode::kLtI32, {less, a, c});
  const std::uint32_t skip = max2.jump(Opcode::kCondJump, {less});
  max2.op(Opcode::kMove32, {result, c});
  max2.land(skip);
  max2.path(Opcode::kStoreVia, {at, result, s.dint}, {});
  s.max2 = max2.finish();

  PouBuilder motor = b.pou("Motor", PouKind::kFunctionBlock);
  const Word run = motor.variable("run", s.boolean, FieldRole::kInput);
  const Word speed = motor.variable("speed", s.integer, FieldRole::kOutput);
  const Word ton = motor.variable("ton", b.block_type("TON"));
  motor.alias("sensor", 3);
  motor.record(0x2, ton, {run, s.go});
  motor.op(Opcode::kRunTb, {b.block("TON"), ton});
  motor.op(Opcode::kAdd16, {speed, speed, s.one});
  s.motor = motor.finish();

  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const std::uint32_t motor_type = b.image.pous[s.motor].instance_type;
  s.motors = b.array(motor_type, 2, 1);
  s.grid = b.array(s.point, 3, -1);
  const Word motor1 = main.instance_of("motor", s.motor);
  const Word motors = main.variable("motors", s.motors);
  const Word grid = main.variable("grid", s.grid);
  const Word line = main.variable("line", s.line);
  const Word backup = main.variable("backup", s.line);
  const Word at_point = main.variable("point", s.point);
  const Word point_ref = main.variable("r_point", b.ref(s.point));
  s.line_ref = main.variable("r_line", b.ref(s.line));
  s.motor_ref = main.variable("r_motor", b.ref(motor_type));
  const Word element_ref = main.frame("r#0", dint_ref);
  const Word timer_ref = main.frame("r#1", b.ref(b.block_type("TON")));
  const Word ok = main.frame("ok", s.boolean);
  const Word i = main.frame("i", s.integer);
  main.op(Opcode::kAdd16, {s.level, s.level, s.one});
  main.op(Opcode::kMoveStr, {s.title, name});
  main.op(Opcode::kCallPou, {s.motor, motor1});
  main.op(Opcode::kCopy, {backup, line, s.line});
  main.path(Opcode::kRefAt, {s.line_ref, line, s.line}, {});
  main.path(Opcode::kRefVia, {element_ref, s.line_ref, s.line}, {{PathStep::kIndex, i}});
  main.path(Opcode::kLoadVia, {s.total, s.line_ref, s.line}, {{PathStep::kElement, 3}});
  main.path(Opcode::kRefAt, {point_ref, at_point, s.point}, {});
  main.path(Opcode::kRefVia, {element_ref, point_ref, s.point}, {{PathStep::kField, 1}});
  main.op(Opcode::kMoveRef, {element_ref, element_ref});
  main.op(Opcode::kSameRef, {ok, element_ref, point_ref});
  main.path(Opcode::kRefAt, {s.motor_ref, motor1, motor_type}, {});
  main.path(Opcode::kCallVia, {s.motor, s.motor_ref, motor_type}, {});
  main.path(Opcode::kRefAt, {timer_ref, motor1, motor_type}, {{PathStep::kField, 2}});
  main.path(Opcode::kRunVia, {b.block("TON"), timer_ref, b.block_type("TON")}, {});
  main.path(Opcode::kLoadAt, {s.total, grid, s.grid}, {{PathStep::kIndex, s.level}, {PathStep::kField, 1}});
  main.path(Opcode::kStoreAt, {grid, s.total, s.grid}, {{PathStep::kElement, 1}, {PathStep::kField, 0}});
  main.path(Opcode::kCallAt, {s.motor, motors, s.motors}, {{PathStep::kIndex, i}});
  main.path(Opcode::kRunAt, {b.block("TON"), motors, s.motors}, {{PathStep::kIndex, i}, {PathStep::kField, 2}});
  main.list(Opcode::kCallFn, 5, {s.max2, 0, s.total, 1, s.total, 2, s.total, 3, element_ref, 4, at_point});
  b.image.queues.push_back({"orders", s.dint, 4, {0}, 0});
  const Word count = main.frame("count", b.type(TypeId::kUdint));
  main.op(Opcode::kQueuePut, {ok, 0, s.total, s.dint});
  main.op(Opcode::kQueueGet, {ok, 0, s.total, s.dint});
  main.op(Opcode::kQueueCount, {count, 0});
  main.op(Opcode::kQueueSpace, {count, 0});
  main.op(Opcode::kClearEvent);
  main.call_std("ADD:INT", i, {s.level, s.one});
  main.op(Opcode::kEno, {ok});
  main.op(Opcode::kExtract, {ok, s.level, 3});
  main.op(Opcode::kInsert, {s.level, s.level, ok, 15});
  main.op(Opcode::kRangeI16, {i, s.level, s.one, s.limit});
  const std::uint32_t again = main.here();
  main.op(Opcode::kAdd16, {i, i, s.one});
  main.op(Opcode::kLtI16, {ok, i, s.limit});
  const std::uint32_t out = main.jump(Opcode::kCondJump, {ok});
  main.op(Opcode::kLoopJump, {again});
  main.land(out);
  s.main = main.finish();
  bytecode::DebugEntry entry;
  entry.at = {12, 3, 10'000'000'001, 0, core::ElementKind::kBlock};
  b.image.pous[s.main].debug.push_back(entry);
  entry.word = 4;
  entry.at = {13, 5, 4, 0, core::ElementKind::kContact};
  b.image.pous[s.main].debug.push_back(entry);

  b.task("Fast", 10'000'000, {s.main});
  s.image = b.build();
  return s;
}

/// The sample with every section that an image may have.
inline Image whole_sample_image() {
  Image image = sample_image().image;
  image.frozen_addresses = "path,table,address,type\nlevel,coils,16384,BOOL\n";
  bytecode::DrawnBody body;
  body.name = "Main";
  body.sheets = {"Main"};
  body.elements.resize(2);
  body.elements[0].kind = core::ElementKind::kContact;
  body.elements[0].text = "go";
  body.elements[0].pins = {{"", "", true, 0, {}, {30, 10}}};
  body.elements[1].pins = {{"IN", "", false, 0, {}, {60, 10}}};
  body.wires = {{0, 0, 1, 0, {{30, 10}, {60, 10}}}};
  image.drawings = bytecode::pack({{body}});
  return image;
}

/// Word index of the `nth` instruction with this opcode.
inline std::size_t find_op(const ImagePou& pou, Opcode opcode, std::size_t nth = 0) {
  for (std::size_t at = 0; at < pou.code.size();) {
    const auto found = static_cast<Opcode>(pou.code[at] & 0xffffu);
    if (found == opcode && nth-- == 0) return at;
    at += bytecode::words_of(bytecode::info(found).operands, pou.code[at] >> 16);
  }
  return pou.code.size();
}

/// A probe map of Main that has every kind of step; the other POUs have nothing to look at.
inline void add_sample_probes(Sample& s) {
  using bytecode::ProbeOp;
  const ImagePou& main = s.image.pous[s.main];
  s.image.probes.assign(s.image.pous.size(), {});
  bytecode::PouProbes& map = s.image.probes[s.main];
  const auto second = static_cast<std::uint32_t>(find_op(main, Opcode::kMoveStr));
  const auto end = static_cast<std::uint32_t>(main.code.size() - 1);
  const auto add = [&map](std::uint32_t word, ProbeOp op, std::uint32_t a = 0, std::uint32_t b = 0) -> auto& {
    map.steps.push_back({word, 0, op, a, b, bytecode::kNoProbeType, bytecode::kNoStep});
    return map.steps.back();
  };
  add(0, ProbeOp::kCapture, s.level).type = s.integer;
  add(0, ProbeOp::kCapture, s.go).type = s.boolean;
  add(0, ProbeOp::kNot, 1);
  add(0, ProbeOp::kConst, 1);
  add(second, ProbeOp::kAnd, 2, 3);
  add(second, ProbeOp::kReached).when = 4;
  add(second, ProbeOp::kCapture, s.title).type = s.label;
  add(second, ProbeOp::kConst, 3).type = s.colour;
  add(second, ProbeOp::kNotComputed);
  add(second, ProbeOp::kOr, 8, 1);
  add(second, ProbeOp::kXor, 8, 4);
  add(end, ProbeOp::kReached);
  add(end, ProbeOp::kReached).order = 1;
  map.jumps = {{static_cast<std::uint32_t>(find_op(main, Opcode::kCondJump)), 1}};
  for (std::uint32_t step = 0; step < map.steps.size(); ++step) {
    map.points.push_back({{0, 10 + step, 13, 5, 0, bytecode::DrawnSide::kOutput}, step});
  }
}

}  // namespace plc::test
