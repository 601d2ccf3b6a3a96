#include "engineering/value_stream.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "engineering/validate.h"
#include "engineering/value_json.h"

namespace plc::engineering {
namespace {

using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;

constexpr std::size_t kMostPaths = 5000;

constexpr Field kSubscribe[] = {field::texts("subscribe", "Paths", kMostPaths)};

template <class T>
void append_number(T value, std::string& out) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof value);
}

std::string refusal_text(const Refusal& refusal) {
  Json body = {{"code", core::info(refusal.code).name}, {"text", refusal.text}};
  if (!refusal.field.empty()) body["field"] = refusal.field;
  if (!refusal.help.empty()) body["help"] = refusal.help;
  return body.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool is_text(const ImageType& type) {
  return type.kind == TypeKind::kString || type.elementary == core::TypeId::kChar ||
         type.elementary == core::TypeId::kWchar;
}

/// What a client reads at a value: "bool", "i16", "f32", "text".
std::string_view form_of(const ImageType& type) {
  if (is_text(type)) return "text";
  switch (bytecode::rep_of(type)) {
    case core::Rep::kBool:
      return "bool";
    case core::Rep::kI8:
      return "i8";
    case core::Rep::kU8:
      return "u8";
    case core::Rep::kI16:
      return "i16";
    case core::Rep::kU16:
      return "u16";
    case core::Rep::kI32:
      return "i32";
    case core::Rep::kU32:
      return "u32";
    case core::Rep::kI64:
      return "i64";
    case core::Rep::kF32:
      return "f32";
    case core::Rep::kF64:
      return "f64";
    default:
      return "u64";
  }
}

/// Before the bits that say which values a frame has.
constexpr std::size_t kHeadBytes = 24;

/// memcmp() == 0, without a call for what most values are.
bool is_same(const std::byte* one, const std::byte* other, std::uint32_t size) {
  const auto equal = [&](auto a) {
    auto b = a;
    std::memcpy(&a, one, sizeof a);
    std::memcpy(&b, other, sizeof b);
    return a == b;
  };
  switch (size) {
    case 1:
      return *one == *other;
    case 2:
      return equal(std::uint16_t{});
    case 4:
      return equal(std::uint32_t{});
    case 8:
      return equal(std::uint64_t{});
    default:
      return std::memcmp(one, other, size) == 0;
  }
}

}  // namespace

ValueStream::ValueStream(Context& context, core::TimeNs period_ns) : context_(context), period_ns_(period_ns) {
  const auto& tasks = context.variables.image().tasks;
  for (std::uint32_t i = 1; i < tasks.size(); ++i) {
    const bool cyclic = tasks[i].single.empty() && tasks[i].period_ns != 0;
    const bool faster = tasks[i].period_ns < tasks[fastest_].period_ns || tasks[fastest_].period_ns == 0;
    if (cyclic && faster) fastest_ = i;
  }
}

void ValueStream::add(const std::string& path, const runtime::Place& place, Json& layout) {
  const bytecode::Image& image = context_.variables.image();
  const ImageType& type = image.types[place.type];
  switch (type.kind) {
    case TypeKind::kRef:
      return;
    case TypeKind::kStruct:
      for (const ImageField& field : type.fields) {
        if (field.name.find('#') != std::string::npos) continue;
        add(path + "." + field.name, {place.task, place.offset + field.offset, field.type, place.constant}, layout);
      }
      return;
    case TypeKind::kArray: {
      const std::uint32_t size = image.types[type.element].size;
      for (std::uint32_t i = 0; i < type.count; ++i) {
        add(path + "[" + std::to_string(type.lower + std::int64_t{i}) + "]",
            {place.task, place.offset + i * size, type.element, place.constant}, layout);
      }
      return;
    }
    case TypeKind::kScalar:
    case TypeKind::kString:
      break;
  }
  Value value;
  value.task = place.task;
  value.offset = place.offset;
  value.type = place.type;
  value.size = type.size;
  value.at = static_cast<std::uint32_t>(newest_.size());
  value.text = is_text(type);
  newest_.resize(newest_.size() + type.size);
  values_.push_back(value);
  Json row = {{"path", path}, {"type", type_name(image, place.type)}, {"form", form_of(type)}};
  if (!type.members.empty()) {
    Json& members = row["members"] = Json::array();
    for (std::size_t m = 0; m < type.members.size(); ++m) {
      members.push_back({{"name", type.members[m]}, {"value", type.member_values[m]}});
    }
  }
  layout.push_back(std::move(row));
}

std::string ValueStream::take(std::string_view text) {
  const auto request = parse_json(text);
  if (!request) return refusal_text({400, core::Code::P7714, "the message is not JSON", {}, {}, 0});
  if (const auto wrong = wrong_fields(*request, kSubscribe)) return refusal_text(*wrong);
  values_.clear();
  runs_.clear();
  newest_.clear();
  Json layout = Json::array(), problems = Json::array();
  for (const Json& path : (*request)["subscribe"]) {
    const auto place = context_.variables.find(path.get<std::string>());
    if (!place) {
      problems.push_back(
          {{"path", path}, {"code", core::info(place.error().code).name}, {"text", place.error().message}});
      continue;
    }
    // WHY before: one path that is too much leaves the others as they are, and costs nothing.
    const std::size_t first = values_.size();
    if (first + leaf_count(context_.variables.image(), place->type) > kMostValues) {
      problems.push_back({{"path", path},
                          {"code", core::info(core::Code::P7717).name},
                          {"text", "with it these are more than " + std::to_string(kMostValues) + " single values"}});
      continue;
    }
    add(path.get<std::string>(), *place, layout);
    add_runs(first);
  }
  ++number_;
  sent_.assign(newest_.size(), std::byte{0});
  whole_ = !values_.empty();
  Json answer;
  answer["subscription"] = number_;
  answer["layout"] = std::move(layout);
  if (!problems.empty()) answer["problems"] = std::move(problems);
  return answer.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void ValueStream::add_runs(std::size_t first) {
  for (std::size_t i = first; i < values_.size(); ++i) {
    const Value& value = values_[i];
    Run* const last = i == first ? nullptr : &runs_.back();
    if (last != nullptr && last->offset + last->size == value.offset) {
      last->size += value.size;
      ++last->count;
    } else {
      runs_.push_back({value.task, value.offset, value.at, value.size, i, 1});
    }
  }
}

void ValueStream::append(const Value& value, std::string& out) const {
  const std::byte* const bytes = newest_.data() + value.at;
  if (!value.text) {
    out.append(reinterpret_cast<const char*>(bytes), value.size);
    return;
  }
  const Json json = value_json(context_.variables.image(), value.type, bytes);
  const auto& text = json.get_ref<const std::string&>();
  const std::size_t length = std::min<std::size_t>(text.size(), UINT16_MAX);
  append_number(static_cast<std::uint16_t>(length), out);
  out.append(text, 0, length);
}

std::optional<Frame> ValueStream::next() {
  if (values_.empty()) return std::nullopt;
  ValueSource& source = context_.variables.values();
  source.take();
  const std::uint64_t scans = fastest_ < context_.variables.image().tasks.size()
                                  ? context_.scheduler.statistics(fastest_).scans.load(std::memory_order_relaxed)
                                  : 0;
  Frame frame{true, {}};
  std::string& bytes = frame.bytes;
  bytes.reserve(kHeadBytes + values_.size() / 8 + 1 + newest_.size());
  append_number(std::uint8_t{1}, bytes);
  append_number(static_cast<std::uint8_t>(whole_ ? 1 : 0), bytes);
  append_number(number_, bytes);
  append_number(static_cast<std::uint32_t>(values_.size()), bytes);
  append_number(scans, bytes);
  append_number(context_.calendar.utc_ns(), bytes);
  bytes.resize(kHeadBytes + (values_.size() + 7) / 8, '\0');
  bool any = whole_;
  for (const Run& run : runs_) {
    source.read(run.task, run.offset, run.size, newest_.data() + run.at);
    if (!whole_ && std::memcmp(newest_.data() + run.at, sent_.data() + run.at, run.size) == 0) continue;
    for (std::size_t i = run.first; i < run.first + run.count; ++i) {
      const Value& value = values_[i];
      if (!whole_ && is_same(newest_.data() + value.at, sent_.data() + value.at, value.size)) continue;
      any = true;
      char& dirty = bytes[kHeadBytes + i / 8];
      dirty = static_cast<char>(static_cast<unsigned char>(dirty) | (1u << (i % 8)));
      append(value, bytes);
    }
  }
  const core::TimeNs now_ns = context_.clock.now_ns();
  if (!any && now_ns - sent_ns_ < kStillNs) return std::nullopt;
  sent_ns_ = now_ns;
  sent_ = newest_;
  whole_ = false;
  return frame;
}

}  // namespace plc::engineering
