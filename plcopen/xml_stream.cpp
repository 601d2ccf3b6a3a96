#include "plcopen/xml_stream.h"

#include <fmt/core.h>
#include <libxml/parser.h>
#include <libxml/parserInternals.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <utility>

#include "core/text.h"

namespace plc::plcopen {

namespace {

constexpr std::string_view kAttributeNames[] = {
#define PLC_ATTRIBUTE(Name, spelling) spelling,
#include "plcopen/attributes.def"
    "xsi:type",
};

/// Bytes of all different names of a file; real ones have some hundreds. The table that holds them is slow when
/// crowded.
constexpr std::size_t kMaxNameBytes = std::size_t{512} << 10;

std::string_view view(const xmlChar* text) {
  return text == nullptr ? std::string_view() : std::string_view(reinterpret_cast<const char*>(text));
}

struct ContextDeleter {
  void operator()(xmlParserCtxt* context) const {
    if (context->myDoc != nullptr) xmlFreeDoc(context->myDoc);
    context->myDoc = nullptr;
    xmlFreeParserCtxt(context);
  }
};

/// libxml2 leaves an ampersand in attribute values as "&#38;" when entities are not substituted.
std::string decode_ampersands(std::string_view value) {
  constexpr std::string_view kEscaped = "&#38;";
  std::string out;
  out.reserve(value.size());
  for (std::size_t i = 0; i < value.size();) {
    out += value[i];
    i += value.substr(i).starts_with(kEscaped) ? kEscaped.size() : 1;
  }
  return out;
}

}  // namespace

std::string_view attribute_name(Attr attribute) { return kAttributeNames[static_cast<std::size_t>(attribute)]; }

/// The C side. Exceptions must not cross libxml2's frames: each callback keeps the first one and stops the parser.
struct XmlParser::Callbacks {
  XmlParser* parser;
  std::exception_ptr error;

  template <class Action>
  static void guarded(void* data, Action action) {
    auto* self = static_cast<Callbacks*>(data);
    if (self->error != nullptr) return;
    try {
      action(*self->parser);
    } catch (...) {
      self->error = std::current_exception();
      self->parser->stop();
    }
  }

  static void start(void* data, const xmlChar* name, const xmlChar* prefix, const xmlChar* uri, int namespace_count,
                    const xmlChar**, int attribute_count, int, const xmlChar** attributes) {
    static_cast<void>(prefix);
    guarded(data, [&](XmlParser& p) { p_start(p, name, uri, namespace_count, attribute_count, attributes); });
  }

  static void p_start(XmlParser& p, const xmlChar* name, const xmlChar* uri, int namespace_count, int attribute_count,
                      const xmlChar** attributes) {
    // The parser is at the '>' or '/>' of the tag; an attribute value cannot contain a '<'.
    const std::size_t end = p.offset();
    const std::size_t open = p.text_.rfind('<', end);
    const std::size_t begin = open == std::string_view::npos ? end : open;
    p.tag_ = begin;
    p.content_ = std::min(end + 1, p.text_.size());
    p.walk_.tag(p.content_);
    p.namespace_marks_.push_back(p.namespaces_);
    p.namespaces_ += static_cast<std::size_t>(namespace_count);
    ++p.depth_;
    ++p.elements_;
    const auto limit = [&](std::size_t value, std::size_t most, std::string_view what) {
      if (value <= most) return true;
      p.problem(core::Code::P1006, begin, fmt::format("file has more than {} {}", most, what));
      p.stop();
      return false;
    };
    if (!limit(p.depth_, p.limits_.max_depth, "levels of nested elements") ||
        !limit(p.elements_, p.limits_.max_elements, "elements") ||
        !limit(p.namespaces_, p.limits_.max_attributes, "namespaces in scope")) {
      return;
    }
    p.fill(attribute_count, attributes);
    p.handler_->start_element(reinterpret_cast<const char*>(name), view(uri), p.attributes_, p.places_.mark(begin));
  }

  static void end(void* data, const xmlChar*, const xmlChar*, const xmlChar*) {
    guarded(data, [](XmlParser& p) {
      p.content_ = p.offset();
      p.walk_.tag(p.content_);
      --p.depth_;
      p.namespaces_ = p.namespace_marks_.back();
      p.namespace_marks_.pop_back();
      p.handler_->end_element();
    });
  }

  static void text(void* data, const xmlChar* piece, int length) {
    guarded(data, [&](XmlParser& p) {
      if (!p.handler_->wants_text()) return;
      const std::string_view text(reinterpret_cast<const char*>(piece), static_cast<std::size_t>(length));
      if (p.handler_->ends_line_before(text)) {
        p.walk_.line_end();
        p.handler_->text("\n");
      }
      p.walk_.piece(text);
      p.handler_->text(text);
    });
  }

  static void declaration(XmlParser& p) {
    p.problem(core::Code::P1005, p.offset(), "DOCTYPE with declarations of its own",
              "remove the DOCTYPE; PLCopen XML needs none");
    p.stop();
  }

  static void entity_declaration(void* data, const xmlChar*, int, const xmlChar*, const xmlChar*, xmlChar*) {
    guarded(data, declaration);
  }

  static void attribute_declaration(void* data, const xmlChar*, const xmlChar*, int, int, const xmlChar*,
                                    xmlEnumeration* tree) {
    xmlFreeEnumeration(tree);
    guarded(data, declaration);
  }

  static xmlParserInput* no_entity_source(void*, const xmlChar*, const xmlChar*) { return nullptr; }
  static xmlEntity* predefined_entity(void*, const xmlChar* name) { return xmlGetPredefinedEntity(name); }
  static xmlEntity* no_parameter_entity(void*, const xmlChar*) { return nullptr; }

  static void error_report(void* data, xmlError* error) {
    guarded(data, [&](XmlParser& p) {
      // Warnings are about namespaces that are no absolute URIs, as the one of IEC 61131-10 is.
      if (error->code == XML_ERR_USER_STOP || error->level == XML_ERR_WARNING || p.failed_) return;
      if (error->code == XML_ERR_NO_MEMORY) {
        p.problem(core::Code::P1006, p.offset(),
                  fmt::format("file has more than {} bytes of different names, or memory is short", kMaxNameBytes));
        return;
      }
      std::string message = error->message == nullptr ? "not well-formed" : error->message;
      while (!message.empty() && (message.back() == '\n' || message.back() == ' ')) message.pop_back();
      if (error->level == XML_ERR_FATAL) {
        p.problem(core::Code::P1002, p.offset(), std::move(message), "export the project again; the file is damaged");
        p.failed_ = true;
      } else if (p.namespace_problems_++ < kMaxNamespaceProblems) {
        p.problem(core::Code::P1004, p.offset(), std::move(message));
      }
    });
  }
};

void XmlParser::problem(core::Code code, std::size_t offset, std::string message, std::string help) {
  const Place place = places_.at(offset);
  diagnostics_.report(code, {.line = place.line, .column = place.column, .file = file_}, {}, std::move(message),
                      std::move(help));
  if (core::info(code).severity == core::Severity::kError) failed_ = true;
}

void XmlParser::stop() {
  failed_ = true;
  xmlStopParser(static_cast<xmlParserCtxt*>(context_));
}

std::size_t XmlParser::offset() const {
  const auto* context = static_cast<const xmlParserCtxt*>(context_);
  if (context->input == nullptr || context->input->cur == nullptr) return 0;
  // The buffer is ours and never copied, so libxml2's cursor points into it (until the parser was stopped).
  const auto* cur = reinterpret_cast<const char*>(context->input->cur);
  if (std::less<>()(cur, text_.data()) || std::less<>()(text_.data() + text_.size(), cur)) return text_.size();
  return static_cast<std::size_t>(cur - text_.data());
}

const XmlParser::CachedName& XmlParser::attribute_of(const char* name) {
  CachedName& slot = names_[(reinterpret_cast<std::uintptr_t>(name) >> 3) % names_.size()];
  if (slot.name != name) {
    slot.name = name;
    const auto* const last = std::end(kAttributeNames) - 1;
    const auto* const found = std::find(std::begin(kAttributeNames), last, std::string_view(name));
    slot.attribute = found == last ? -1 : static_cast<int>(found - std::begin(kAttributeNames));
    slot.meant = -1;
    if (found == last) {
      const auto* const meant = std::find_if(std::begin(kAttributeNames), last,
                                             [&](std::string_view known) { return core::iequals(known, name); });
      if (meant != last) slot.meant = static_cast<int>(meant - std::begin(kAttributeNames));
    }
  }
  return slot;
}

void XmlParser::fill(int count, const unsigned char** attributes) {
  Attributes& a = attributes_;
  ++a.stamp_;
  a.decoded_.clear();
  a.other_case_ = {};
  // libxml2 gives five pointers per attribute: local name, prefix, namespace, value, end of the value.
  for (int i = 0; i < count; ++i, attributes += 5) {
    const auto* name = reinterpret_cast<const char*>(attributes[0]);
    const CachedName& known = attribute_of(name);
    Attr attribute = known.attribute < 0 ? Attr{0xFF} : static_cast<Attr>(known.attribute);
    if (attributes[1] != nullptr) {
      const bool xsi = view(attributes[1]) == "xsi" || view(attributes[2]).ends_with("XMLSchema-instance");
      if (!xsi || attribute != Attr::kType) continue;
      attribute = Attr::kXsiType;
    }
    if (attribute == Attr{0xFF}) {
      if (known.meant < 0) continue;
      a.other_case_ = name;
      a.meant_ = static_cast<Attr>(known.meant);
      continue;
    }
    std::string_view value(reinterpret_cast<const char*>(attributes[3]),
                           static_cast<std::size_t>(attributes[4] - attributes[3]));
    if (value.find('&') != std::string_view::npos) value = a.decoded_.emplace_back(decode_ampersands(value));
    a.values_[static_cast<std::size_t>(attribute)] = value;
    a.stamps_[static_cast<std::size_t>(attribute)] = a.stamp_;
  }
}

std::optional<Place> XmlParser::value_place(Attr attribute) {
  const std::string_view wanted = attribute == Attr::kXsiType ? "type" : attribute_name(attribute);
  const auto skip_blanks = [&](std::size_t from) { return text_.find_first_not_of(" \t\r\n", from); };
  std::size_t i = text_.find_first_of(" \t\r\n/>", tag_);
  for (i = skip_blanks(i); i != std::string_view::npos && text_[i] != '/' && text_[i] != '>'; i = skip_blanks(i)) {
    const std::size_t equals = text_.find('=', i);
    if (equals == std::string_view::npos) return std::nullopt;
    std::string_view name = core::trimmed(text_.substr(i, equals - i));
    name.remove_prefix(name.rfind(':') + 1);
    const std::size_t quote = skip_blanks(equals + 1);
    if (quote == std::string_view::npos) return std::nullopt;
    const std::size_t end = text_.find(text_[quote], quote + 1);
    if (end == std::string_view::npos) return std::nullopt;
    if (name == wanted) {
      walk_.attribute(quote + 1, attributes_.get(attribute));
      return walk_.first();
    }
    i = end + 1;
  }
  return std::nullopt;
}

bool XmlParser::run(XmlHandler& handler) {
  xmlInitParser();
  handler_ = &handler;
  Callbacks callbacks{this, nullptr};
  xmlSAXHandler sax{};
  sax.initialized = XML_SAX2_MAGIC;
  sax.startElementNs = Callbacks::start;
  sax.endElementNs = Callbacks::end;
  sax.characters = Callbacks::text;
  sax.ignorableWhitespace = Callbacks::text;
  sax.cdataBlock = Callbacks::text;
  sax.entityDecl = Callbacks::entity_declaration;
  sax.attributeDecl = Callbacks::attribute_declaration;
  sax.resolveEntity = Callbacks::no_entity_source;
  sax.getEntity = Callbacks::predefined_entity;
  sax.getParameterEntity = Callbacks::no_parameter_entity;
  sax.serror = Callbacks::error_report;

  const std::unique_ptr<xmlParserCtxt, ContextDeleter> context(xmlNewParserCtxt());
  if (context == nullptr) throw std::bad_alloc();
  context_ = context.get();
  *context->sax = sax;
  context->userData = &callbacks;
  // HUGE lifts libxml2's own limits, ours hold; the declared encoding is ignored because the text is UTF-8 by now.
  xmlCtxtUseOptions(context.get(), XML_PARSE_NONET | XML_PARSE_HUGE | XML_PARSE_IGNORE_ENC);
  xmlDictSetLimit(context->dict, kMaxNameBytes);

  // A string is parsed in place. The push interface of libxml2 2.9 would copy it, and needs quadratic time for a long
  // CDATA section, because it scans again from its start with every chunk.
  xmlParserInput* input = xmlNewStringInputStream(context.get(), reinterpret_cast<const xmlChar*>(text_.data()));
  if (input == nullptr) throw std::bad_alloc();
  if (inputPush(context.get(), input) < 0) {
    xmlFreeInputStream(input);
    throw std::bad_alloc();
  }
  xmlParseDocument(context.get());
  if (callbacks.error != nullptr) std::rethrow_exception(callbacks.error);
  if (!failed_ && context->wellFormed == 0) problem(core::Code::P1002, offset(), "not well-formed");
  context_ = nullptr;
  diagnostics_.set_text_jumps(file_, std::move(walk_.jumps()));
  return !failed_;
}

}  // namespace plc::plcopen
