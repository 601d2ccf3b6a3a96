// PLCopen XML (TC6 2.01) as editors import it, piece by piece: what libraries of declarations are written with.
//
// In: names, types, words. Out: elements as text. Does not belong here: which POUs there are (library_xml.h,
// taskblock_xml.h).
#pragma once

#include <string>
#include <string_view>

#include "core/types.h"

namespace plc::tools {

/// Text as the content of an element or an attribute in double quotes.
std::string xml_escaped(std::string_view text);
/// A <documentation> of one paragraph.
std::string documentation_xml(std::string_view text);
/// Content of a <type>. The schema has elements for the types of the second edition; those of the third are types by
/// name.
std::string type_xml(core::TypeId type);
/// A line of an interface or a structure; `type` is the content of its <type>. An empty initial value or summary is
/// left out. A simple value only: no array, no structure.
std::string variable_xml(std::string_view name, const std::string& type, std::string_view summary,
                         std::string_view initial = {});
/// The variables inside of `element`, which may have attributes ("inputVars constant=\"true\""); nothing without any.
std::string section_xml(std::string_view element, const std::string& variables);
/// A POU of kind "function" or "functionBlock" without statements. Its body is a comment that tells where the real one
/// is: editors refuse a POU that has none.
std::string pou_xml(std::string_view name, std::string_view kind, const std::string& interface,
                    std::string_view documentation, std::string_view body_comment);
/// A project of declarations; `data_types` and `pous` are elements of them, each on lines of their own.
std::string project_xml(std::string_view name, const std::string& data_types, const std::string& pous);

}  // namespace plc::tools
