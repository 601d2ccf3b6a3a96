// The OpenAPI document: whole, and of the rows.
#include "engineering/openapi.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tests/unit/engineering/rig.h"

namespace plc::test {
namespace {

using engineering::Call;
using engineering::calls;
using engineering::openapi_document;
using engineering::openapi_text;

/// Calls each(node, path) for every object in the document.
template <class Each>
void walk(const Json& node, const std::string& path, Each each) {
  if (node.is_object()) {
    each(node, path);
    for (const auto& [name, part] : node.items()) walk(part, path + "/" + name, each);
  } else if (node.is_array()) {
    for (std::size_t i = 0; i < node.size(); ++i) walk(node[i], path + "/" + std::to_string(i), each);
  }
}

TEST(OpenApi, HasEveryCallOnce) {
  const Json& document = openapi_document();
  EXPECT_EQ(document["openapi"], "3.1.0");
  EXPECT_EQ(document["paths"].size(), calls().size());
  std::set<std::string> names, paths;
  for (const Call& call : calls()) {
    EXPECT_TRUE(names.insert(std::string(call.name)).second) << call.name;
    EXPECT_TRUE(paths.insert(std::string(call.path)).second) << call.path;
    const Json& path = document["paths"][std::string(call.path)];
    ASSERT_EQ(path.size(), 1u);
    EXPECT_EQ(path.begin().value()["operationId"], call.name);
  }
}

TEST(OpenApi, LeadsNowhereElse) {
  const Json& document = openapi_document();
  std::set<std::string> used;
  walk(document, "", [&](const Json& node, const std::string& path) {
    if (!node.contains("$ref")) return;
    const std::string target = node["$ref"];
    ASSERT_EQ(target.find("#/components/schemas/"), 0u) << path;
    const std::string name = target.substr(target.rfind('/') + 1);
    EXPECT_TRUE(document["components"]["schemas"].contains(name)) << path << " names " << name;
    used.insert(name);
  });
  EXPECT_EQ(used.size(), document["components"]["schemas"].size()) << "a schema that nobody uses";
}

TEST(OpenApi, SchemasAreOfJsonSchema) {
  const std::set<std::string> types = {"object", "array", "string", "integer", "number", "boolean", "null"};
  walk(openapi_document(), "", [&](const Json& node, const std::string& path) {
    if (path.find("/properties") != std::string::npos && path.ends_with("/properties")) return;
    if (node.contains("type") && path.find("securitySchemes") == std::string::npos) {
      const Json& type = node["type"];
      if (type.is_array()) {
        for (const Json& one : type) EXPECT_TRUE(types.count(one)) << path;
      } else if (type.is_string()) {
        EXPECT_TRUE(types.count(type)) << path << " " << type;
        if (type == "array") {
          EXPECT_TRUE(node.contains("items")) << path;
        }
      }
    }
    if (!node.contains("required") || !node["required"].is_array()) return;
    for (const Json& name : node["required"]) EXPECT_TRUE(node["properties"].contains(name)) << path << " " << name;
  });
}

TEST(OpenApi, SaysWhatEveryThingIs) {
  walk(openapi_document(), "", [&](const Json& node, const std::string& path) {
    if (node.contains("operationId")) {
      EXPECT_GT(node["summary"].get<std::string>().size(), 5u) << path;
      EXPECT_TRUE(node["responses"].contains("default")) << path;
    }
    if (node.contains("description")) {
      const std::string text = node["description"];
      EXPECT_GT(text.size(), 3u) << path;
      EXPECT_EQ(text.back(), '.') << path << ": " << text;
      EXPECT_EQ(text.find(".."), std::string::npos) << path << ": " << text;
    }
  });
}

TEST(OpenApi, IsServedToAnybody) {
  EngineeringRig rig;
  const HttpResponse response = rig.get("/api/openapi.json", "");
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(body_of(response), openapi_document());
  EXPECT_EQ(response.body, openapi_text());
  EXPECT_EQ(&openapi_text(), &openapi_text()) << "it is made once, not for each request";
}

}  // namespace
}  // namespace plc::test
