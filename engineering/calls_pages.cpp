// HMI pages: calls of the subject "pages".
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/first_page.h"
#include "engineering/subjects.h"
#include "hmi/rows.h"

namespace plc::engineering {
namespace {

using namespace field;
using core::Code;
using hmi::KeyType;

constexpr std::size_t kPlaceFields = 5;

constexpr Field field_of(const hmi::KeyRow& row) {
  switch (row.type) {
    case KeyType::kText: {
      Field field = text(row.name, row.doc, 0, hmi::kMostText);
      field.choices = row.choices;
      return optional(field);
    }
    case KeyType::kInteger:
      return optional(integer(row.name, row.doc));
    case KeyType::kNumber:
      return optional(number(row.name, row.doc));
    case KeyType::kBoolean:
      return optional(boolean(row.name, row.doc));
    case KeyType::kValue:
      return optional(value(row.name, row.doc));
    case KeyType::kTexts:
      break;
  }
  return optional(texts(row.name, row.doc, hmi::kMostPlotted));
}

/// The keys of [[page.element]], as the rows of the file have them.
constexpr auto kElementFields = [] {
  std::array<Field, kPlaceFields + hmi::kKeyCount + 1> fields{
      text("kind", "Kind of the element, one of kinds", 1, 40),
      integer("x", "Column of the left side, from 0", 0, hmi::kMostCells),
      integer("y", "Row of the upper side, from 0", 0, hmi::kMostCells),
      integer("width", "Columns", 1, hmi::kMostCells),
      integer("height", "Rows", 1, hmi::kMostCells),
  };
  for (std::size_t i = 0; i < hmi::kKeyCount; ++i) fields[kPlaceFields + i] = field_of(hmi::kKeys[i]);
  fields.back() = optional(texts("comment", "Lines of the comment in pages.toml, without #", 1000));
  return fields;
}();
constexpr Record kElement = {"HmiElement", "One thing on an HMI page: the table [[page.element]].", kElementFields};

constexpr Field kPageFields[] = {
    text("name", "Name, for links and addresses", 1, 40),
    optional(text("title", "What people read", 0, hmi::kMostText)),
    integer("columns", "Cells from left to right", 1, hmi::kMostCells),
    integer("rows", "Cells from top to bottom", 1, hmi::kMostCells),
    records("elements", kElement, "In the order of the file: later ones lie above", hmi::kMostElements),
    optional(texts("comment", "Lines of the comment in pages.toml, without #", 1000)),
};
constexpr Record kPage = {"HmiPage", "A page of elements on a grid: the table [[page]].", kPageFields};

constexpr Field kKeyFields[] = {
    text("name", "Name of the key"),
    choice("type", "text|integer|number|boolean|value|texts", "What it takes"),
    boolean("required", "The element cannot be without"),
    text("doc", "What it means"),
    optional(texts("choices", "Where it is one of a few words")),
};
constexpr Record kKey = {"HmiKey", "A key that elements of a kind have.", kKeyFields};
constexpr Field kKindFields[] = {
    text("name", "As kind of an element names it"), text("doc", "What it is"),
    integer("width", "Columns of a new one"),       integer("height", "Rows of a new one"),
    boolean("writes", "It is for writing"),         records("keys", kKey, "In the order of the file"),
};
constexpr Record kKindRecord = {"HmiKind", "A kind of element.", kKindFields};

constexpr Field kGetAnswer[] = {
    text("version", "Of pages.toml; empty without one. pages.save wants it"),
    boolean("made", "There is no pages.toml: the page is made from the program"),
    boolean("usable", "The newest pages.toml has no error; else the pages are those of before"),
    records("pages", kPage, "In the order of the file"),
    texts("comment", "Lines of the comment at the beginning of pages.toml, without #"),
    texts("problems", "What is wrong in pages.toml, with line and column"),
    records("kinds", kKindRecord, "What elements there are"),
};

Json json_of(const hmi::Value& value) {
  return std::visit(
      [](const auto& one) -> Json {
        if constexpr (std::is_same_v<std::decay_t<decltype(one)>, std::monostate>) {
          return nullptr;
        } else {
          return one;
        }
      },
      value);
}

Json page_json(const hmi::Page& page) {
  Json row = {{"name", page.name}};
  if (!page.title.empty()) row["title"] = page.title;
  row["columns"] = page.columns;
  row["rows"] = page.rows;
  Json& elements = row["elements"] = Json::array();
  for (const hmi::Element& element : page.elements) {
    Json one = {{"kind", row_of(element.kind).name},
                {"x", element.x},
                {"y", element.y},
                {"width", element.width},
                {"height", element.height}};
    for (std::size_t i = 0; i < hmi::kKeyCount; ++i) {
      if (element.values[i].index() != 0) one[std::string(hmi::kKeys[i].name)] = json_of(element.values[i]);
    }
    if (!element.comment.empty()) one["comment"] = element.comment;
    elements.push_back(std::move(one));
  }
  if (!page.comment.empty()) row["comment"] = page.comment;
  return row;
}

Json kinds_json() {
  constexpr std::string_view kTypes[] = {"text", "integer", "number", "boolean", "value", "texts"};
  Json all = Json::array();
  for (std::size_t kind = 0; kind < std::size(hmi::kKinds); ++kind) {
    const hmi::KindRow& row = hmi::kKinds[kind];
    Json keys = Json::array();
    for (const hmi::KeyRow& key : hmi::kKeys) {
      const std::uint32_t bit = hmi::bit(static_cast<hmi::Kind>(kind));
      if ((key.kinds & bit) == 0) continue;
      Json one = {{"name", key.name},
                  {"type", kTypes[static_cast<std::size_t>(key.type)]},
                  {"required", (key.required & bit) != 0},
                  {"doc", key.doc}};
      for (std::string_view rest = key.choices; !rest.empty();) {
        const std::size_t bar = std::min(rest.find('|'), rest.size());
        one["choices"].push_back(rest.substr(0, bar));
        rest.remove_prefix(std::min(bar + 1, rest.size()));
      }
      keys.push_back(std::move(one));
    }
    all.push_back({{"name", row.name},
                   {"doc", row.doc},
                   {"width", row.width},
                   {"height", row.height},
                   {"writes", row.use == hmi::Use::kWrites},
                   {"keys", std::move(keys)}});
  }
  return all;
}

void get(Context& context, const Caller&, const Json&, Answer& answer) {
  const auto state = context.hmi.state();
  Json& body = answer.body();
  body["version"] = state->version;
  body["made"] = !state->there;
  body["usable"] = state->usable;
  Json& pages = body["pages"] = Json::array();
  const hmi::Document made = state->there ? hmi::Document() : first_page(context.variables, context.identity.plant);
  const hmi::Document& document = state->there ? state->document : made;
  for (const hmi::Page& page : document.pages) pages.push_back(page_json(page));
  body["comment"] = document.comment;
  body["problems"] = state->texts;
  body["kinds"] = kinds_json();
}

constexpr Field kReloadAnswer[] = {
    text("version", "Of pages.toml, as it is now; empty without one"),
    boolean("usable", "It has no error"),
};

void reload(Context& context, const Caller&, const Json&, Answer& answer) {
  context.hmi.read();
  const auto state = context.hmi.state();
  answer.body()["version"] = state->version;
  answer.body()["usable"] = state->usable;
}

constexpr Field kSaveRequest[] = {
    text("version", "The one that the pages were made from, as pages.get told it", 0, 64),
    records("pages", kPage, "All pages", hmi::kMostPages),
    optional(texts("comment", "Lines of the comment at the beginning of pages.toml, without #", 1000)),
};
constexpr Field kSaveAnswer[] = {
    text("version", "Of the file as it was written"),
    texts("problems", "What is not right in it, and may become right: variables that are not there"),
};

std::vector<std::string> comment_of(const Json& row) {
  std::vector<std::string> lines;
  if (!row.contains("comment")) return lines;
  for (const Json& line : row["comment"]) {
    std::string text = line.get<std::string>();
    // A line stays one, whatever it holds.
    std::replace_if(
        text.begin(), text.end(),
        [](char c) { return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f; }, ' ');
    lines.push_back(std::move(text));
  }
  return lines;
}

hmi::Value value_of(const Json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number()) return value.get<double>();
  if (value.is_string()) return value.get<std::string>();
  if (value.is_array()) {
    std::vector<std::string> texts;
    for (const Json& one : value) texts.push_back(one.is_string() ? one.get<std::string>() : std::string());
    return texts;
  }
  return {};
}

/// False when its kind is none.
bool take_element(const Json& row, hmi::Element& element) {
  const auto kind = row["kind"].get<std::string>();
  const auto* const found =
      std::find_if(std::begin(hmi::kKinds), std::end(hmi::kKinds), [&](const auto& one) { return one.name == kind; });
  if (found == std::end(hmi::kKinds)) return false;
  element.kind = static_cast<hmi::Kind>(found - hmi::kKinds);
  element.x = row["x"].get<std::int64_t>();
  element.y = row["y"].get<std::int64_t>();
  element.width = row["width"].get<std::int64_t>();
  element.height = row["height"].get<std::int64_t>();
  for (std::size_t i = 0; i < hmi::kKeyCount; ++i) {
    const std::string name(hmi::kKeys[i].name);
    if (row.contains(name)) element.values[i] = value_of(row[name]);
  }
  element.comment = comment_of(row);
  return true;
}

void save(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  hmi::Document document;
  document.comment = comment_of(request);
  std::size_t elements = 0;
  for (const Json& row : request["pages"]) {
    hmi::Page page;
    page.name = row["name"].get<std::string>();
    page.title = row.value("title", "");
    page.columns = row["columns"].get<std::int64_t>();
    page.rows = row["rows"].get<std::int64_t>();
    page.comment = comment_of(row);
    for (const Json& one : row["elements"]) {
      if (!take_element(one, page.elements.emplace_back())) {
        return answer.refuse(
            400, Code::P7771, "\"" + one["kind"].get<std::string>() + "\" is no kind of element",
            fmt::format("pages[{}].elements[{}].kind", document.pages.size(), page.elements.size() - 1));
      }
      ++elements;
    }
    document.pages.push_back(std::move(page));
  }
  std::string field = "pages";
  if (const auto problem = context.hmi.save(request["version"].get<std::string>(), document, field)) {
    const bool of_request = problem->code >= Code::P7770 && problem->code <= Code::P7775;
    return answer.refuse(of_request ? 400 : 409, problem->code, problem->message,
                         problem->code == Code::P7778 ? "version" : field, problem->help);
  }
  const auto state = context.hmi.state();
  context.audit.add(caller.user, caller.address, "pages.save",
                    {{"version", state->version}, {"pages", document.pages.size()}, {"elements", elements}});
  answer.body()["version"] = state->version;
  answer.body()["problems"] = state->texts;
}

constexpr Field kPressRequest[] = {
    text("path", "The BOOL of a button", 1, 1000),
    boolean("pressed", "Say true again within 3 s as long as it is held, then false"),
    optional(boolean("renews", "Says again that it is held; presses nothing that is not held any more")),
    optional(integer("until_ms",
                     "UTC in milliseconds, by the clock of the machine: what comes later presses nothing. It does not "
                     "protect when that clock is set back meanwhile")),
};
constexpr Field kPressAnswer[] = {boolean("held", "The caller holds it now; false after a press: it came too late")};

void press(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  const auto path = request["path"].get<std::string>();
  const Presses::Holder holder{caller.user, caller.session};
  const core::TimeNs now_ns = context.clock.now_ns();
  if (!request["pressed"].get<bool>()) {
    if (context.presses.release(path, holder, now_ns)) {
      context.audit.add(caller.user, caller.address, "pages.press", {{"path", path}, {"pressed", false}});
    }
    answer.body()["held"] = false;
    return;
  }
  if (const auto problem = context.hmi.press_refusal(path)) return answer.refuse(*problem, "path");
  if (context.is_late(request)) {
    answer.body()["held"] = false;
    return;
  }
  const Presses::Pressed pressed = context.presses.press(path, holder, request.value("renews", false), now_ns);
  if (pressed.problem) return answer.refuse(*pressed.problem, "path");
  if (pressed.fresh) {
    context.audit.add(caller.user, caller.address, "pages.press", {{"path", path}, {"pressed", true}});
  }
  answer.body()["held"] = pressed.held;
}

constexpr Field kPictureRequest[] = {
    text("file", "Its name, beside pages.toml: .png, .jpg, .gif, .webp, .svg", 1, 200)};

void picture(Context& context, const Caller&, const Json& request, Answer& answer) {
  auto found = context.hmi.picture(request["file"].get<std::string>());
  if (!found) return answer.refuse(404, found.error().code, found.error().message, "file");
  answer.give_picture(std::move(found->bytes), std::string(found->type));
}

constexpr Call kCalls[] = {
    {.name = "pages.get",
     .path = "/api/pages",
     .doc = "The HMI pages of the project: pages.toml in its folder, as it was read last; without one a page that is "
            "made from the program.",
     .response = kGetAnswer,
     .example = R"({})",
     .run = get},
    {.name = "pages.reload",
     .method = Method::kPost,
     .path = "/api/pages/reload",
     .doc = "Reads pages.toml where it has changed since it was read last.",
     .response = kReloadAnswer,
     .example = R"({})",
     .run = reload,
     .thread = Thread::kFiles},
    {.name = "pages.save",
     .method = Method::kPost,
     .path = "/api/pages/save",
     .right = Right::kEngineer,
     .doc = "Writes pages.toml, all of it, in one step. Refused when somebody else has changed it meanwhile. Recorded "
            "in the audit.",
     .request = kSaveRequest,
     .response = kSaveAnswer,
     .example = R"({"version": "", "pages": [{"name": "pump", "columns": 24, "rows": 14, "elements": []}]})",
     .run = save,
     .thread = Thread::kFiles},
    {.name = "pages.press",
     .method = Method::kPost,
     .path = "/api/pages/press",
     .right = Right::kOperator,
     .doc =
         "Holds a button of a page, or lets go of it. Its BOOL is TRUE for one scan at least of every cyclic task that "
         "takes it in, and becomes FALSE by itself when nobody says for 3 s that it is held. Recorded in the audit.",
     .request = kPressRequest,
     .response = kPressAnswer,
     .example = R"({"path": "Start", "pressed": true})",
     .run = press},
    {.name = "pages.picture",
     .path = "/api/pages/picture",
     .doc = "A picture from the folder of the project, at most 5 MB.",
     .request = kPictureRequest,
     .example = R"({"file": "plant.svg"})",
     .run = picture,
     .form = Form::kFile,
     .thread = Thread::kFiles},
};

}  // namespace

std::span<const Call> page_calls() { return kCalls; }

}  // namespace plc::engineering
