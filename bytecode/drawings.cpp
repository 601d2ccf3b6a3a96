#include "bytecode/drawings.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "bytecode/byte_io.h"

namespace plc::bytecode {

namespace {

// Layout: u8 form, u64 size of the content, content; compressed or, where that does not pay or would look like an
// attack, as it is.
enum class Form : std::uint8_t { kPlain, kZstd };
constexpr std::size_t kHeadBytes = 9;
constexpr int kLevel = 3;
/// A few bytes must not unpack to all memory of a machine.
constexpr std::uint64_t kMostExpansion = 256;

class Writer {
 public:
  template <class T>
  void number(const T& value) {
    out_.put(value);
  }
  template <class E>
  void one_of(const E& value, E) {
    out_.put(static_cast<std::uint8_t>(value));
  }
  void flag(const bool& value) { out_.put(static_cast<std::uint8_t>(value)); }
  void place(const std::int32_t& value) { out_.put(value); }
  void text(const std::string& value) {
    out_.put(static_cast<std::uint32_t>(value.size()));
    out_.put_bytes(std::as_bytes(std::span(value)));
  }
  /// `record_bytes`: the least that an item takes.
  template <class T, class Each>
  void list(const std::vector<T>& items, std::size_t, const Each& each) {
    out_.put(static_cast<std::uint32_t>(items.size()));
    for (const T& item : items) each(item);
  }
  std::vector<std::byte>& bytes() { return out_.bytes(); }

 private:
  ByteWriter out_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : in_(bytes) {}
  template <class T>
  void number(T& value) {
    value = in_.get<T>();
  }
  template <class E>
  void one_of(E& value, E last) {
    const auto read = in_.get<std::uint8_t>();
    if (read > static_cast<std::uint8_t>(last)) return in_.fail();
    value = static_cast<E>(read);
  }
  void flag(bool& value) {
    const auto read = in_.get<std::uint8_t>();
    if (read > 1) in_.fail();
    value = read == 1;
  }
  void place(std::int32_t& value) {
    value = in_.get<std::int32_t>();
    if (value < 0 || value > kMaxDrawn) in_.fail();
  }
  void text(std::string& value) {
    const auto bytes = in_.take(in_.get<std::uint32_t>());
    value.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  template <class T, class Each>
  void list(std::vector<T>& items, std::size_t record_bytes, const Each& each) {
    const std::uint32_t n = in_.count(record_bytes);
    items.reserve(n);
    for (std::uint32_t i = 0; i < n && !in_.failed(); ++i) each(items.emplace_back());
  }
  [[nodiscard]] bool whole() const { return !in_.failed() && in_.at_end(); }

 private:
  ByteReader in_;
};

// One function for both directions: Archive is a Writer with constant structures, or a Reader.

template <class Archive, class Point>
void exchange_point(Archive& a, Point& p) {
  a.place(p.x);
  a.place(p.y);
}

template <class Archive, class Modifiers>
void exchange_modifiers(Archive& a, Modifiers& m) {
  a.flag(m.negated);
  a.one_of(m.edge, DrawnEdge::kFalling);
  a.one_of(m.storage, DrawnStorage::kReset);
}

template <class Archive, class Element>
void exchange_element(Archive& a, Element& e) {
  a.one_of(e.kind, core::kLastElementKind);
  a.number(e.local_id);
  a.number(e.line);
  a.number(e.column);
  a.number(e.sheet);
  a.number(e.network);
  a.text(e.text);
  a.text(e.instance);
  a.text(e.code);
  exchange_modifiers(a, e.modifiers);
  a.place(e.x);
  a.place(e.y);
  a.place(e.width);
  a.place(e.height);
  a.list(e.pins, 22, [&](auto& pin) {
    a.text(pin.name);
    a.text(pin.text);
    a.flag(pin.output);
    a.number(pin.pin);
    exchange_modifiers(a, pin.modifiers);
    exchange_point(a, pin.at);
  });
  a.flag(e.initial);
  a.number(e.priority);
  a.number(e.macro_sheet);
  a.list(e.actions, 24, [&](auto& action) {
    a.text(action.qualifier);
    a.text(action.text);
    a.text(action.time);
    a.text(action.indicator);
    a.number(action.line);
    a.number(action.column);
  });
}

template <class Archive, class Body>
void exchange_body(Archive& a, Body& b) {
  a.text(b.name);
  a.one_of(b.owner, kLastDrawnOwner);
  a.text(b.worksheet);
  a.one_of(b.language, kLastDrawnLanguage);
  a.text(b.file);
  a.list(b.elements, 77, [&](auto& e) { exchange_element(a, e); });
  a.list(b.wires, 20, [&](auto& wire) {
    a.number(wire.from);
    a.number(wire.from_pin);
    a.number(wire.to);
    a.number(wire.to_pin);
    a.list(wire.points, 8, [&](auto& point) { exchange_point(a, point); });
  });
  a.list(b.comments, 22, [&](auto& comment) {
    a.text(comment.text);
    a.number(comment.sheet);
    a.place(comment.x);
    a.place(comment.y);
    a.place(comment.width);
    a.place(comment.height);
  });
  a.list(b.sheets, 4, [&](auto& sheet) { a.text(sheet); });
  a.text(b.text);
  a.number(b.text_line);
  a.number(b.text_column);
  a.list(b.statements, 16, [&](auto& statement) {
    a.number(statement.line);
    a.number(statement.column);
    a.number(statement.end_line);
    a.number(statement.end_column);
  });
}

template <class Archive, class All>
void exchange(Archive& a, All& drawings) {
  a.list(drawings.bodies, 46, [&](auto& body) { exchange_body(a, body); });
}

// ---- what a body refers to ------------------------------------------------------------------------------------------

bool has_pin(const DrawnBody& body, std::uint32_t element, std::uint32_t pin, bool output) {
  return element < body.elements.size() && pin < body.elements[element].pins.size() &&
         body.elements[element].pins[pin].output == output;
}

bool sound(const DrawnBody& body) {
  const auto sheet = [&](std::uint16_t index) { return index < body.sheets.size(); };
  return std::all_of(
             body.elements.begin(), body.elements.end(),
             [&](const DrawnElement& e) { return sheet(e.sheet) && (e.macro_sheet == 0 || sheet(e.macro_sheet)); }) &&
         std::all_of(body.comments.begin(), body.comments.end(),
                     [&](const DrawnComment& c) { return sheet(c.sheet); }) &&
         std::all_of(body.wires.begin(), body.wires.end(),
                     [&](const DrawnWire& w) {
                       return has_pin(body, w.from, w.from_pin, true) && has_pin(body, w.to, w.to_pin, false) &&
                              w.points.size() >= 2;
                     }) &&
         std::all_of(body.statements.begin(), body.statements.end(), [](const DrawnStatement& s) {
           return s.end_line > s.line || (s.end_line == s.line && s.end_column >= s.column);
         });
}

core::Problem damaged() {
  return {core::Code::P6004, "the drawings in the image do not make sense",
          "copy the image again, or compile the project again"};
}

}  // namespace

std::vector<std::byte> pack(const Drawings& drawings) {
  Writer writer;
  exchange(writer, drawings);
  const std::vector<std::byte>& content = writer.bytes();
  std::vector<std::byte> out(kHeadBytes + ZSTD_compressBound(content.size()));
  const std::size_t packed =
      ZSTD_compress(out.data() + kHeadBytes, out.size() - kHeadBytes, content.data(), content.size(), kLevel);
  const bool pays = ZSTD_isError(packed) == 0 && packed < content.size() - content.size() / 8 &&
                    packed * kMostExpansion >= content.size();
  out.resize(kHeadBytes + (pays ? packed : content.size()));
  if (!pays) std::copy(content.begin(), content.end(), out.begin() + kHeadBytes);
  out[0] = static_cast<std::byte>(pays ? Form::kZstd : Form::kPlain);
  store_le(out.data() + 1, static_cast<std::uint64_t>(content.size()));
  return out;
}

core::Result<Drawings> unpack(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeadBytes) return damaged();
  const auto size = load_le<std::uint64_t>(bytes.data() + 1);
  const auto stored = bytes.subspan(kHeadBytes);
  std::span<const std::byte> content = stored;
  std::vector<std::byte> unpacked;
  if (bytes[0] == static_cast<std::byte>(Form::kZstd)) {
    if (size > kMaxUnpackedBytes || size / kMostExpansion > stored.size()) return damaged();
    unpacked.resize(static_cast<std::size_t>(size));
    if (ZSTD_decompress(unpacked.data(), unpacked.size(), stored.data(), stored.size()) != size) return damaged();
    content = unpacked;
  } else if (bytes[0] != static_cast<std::byte>(Form::kPlain) || size != stored.size()) {
    return damaged();
  }
  Reader reader(content);
  Drawings drawings;
  exchange(reader, drawings);
  if (!reader.whole() || !std::all_of(drawings.bodies.begin(), drawings.bodies.end(), sound)) return damaged();
  return drawings;
}

DrawnKey key_of(std::uint32_t pou, const DrawnElement& element) {
  return {pou, element.local_id, element.line, element.column, 0, DrawnSide::kWhole};
}

DrawnKey key_of(std::uint32_t pou, const DrawnElement& element, const DrawnPin& pin) {
  return {pou,          element.local_id,
          element.line, element.column,
          pin.pin,      pin.output ? DrawnSide::kOutput : DrawnSide::kInput};
}

DrawnKey key_of(std::uint32_t pou, const DrawnElement& element, std::size_t action) {
  const DrawnAction& row = element.actions[action];
  if (element.kind == core::ElementKind::kStep && row.line == 0) {
    constexpr std::string_view kOwn[] = {"entry", "main", "exit"};
    const auto* const own = std::find(std::begin(kOwn), std::end(kOwn), row.qualifier);
    return {pou,
            element.local_id,
            element.line,
            element.column,
            static_cast<std::uint16_t>(own - std::begin(kOwn) + 1),
            DrawnSide::kWhole};
  }
  return {pou, element.local_id, row.line, row.column, 0, DrawnSide::kWhole};
}

DrawnKey key_of(std::uint32_t pou, const DrawnStatement& statement) {
  return {pou, -1, statement.line, statement.column, 0, DrawnSide::kWhole};
}

}  // namespace plc::bytecode
