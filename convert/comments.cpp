#include "convert/comments.h"

#include <iterator>
#include <set>
#include <string_view>

#include "core/text.h"

namespace plc::convert {

namespace {

/// Calls `visit` with the place of each declaration of the project, and of each body.
template <class Visit>
class Places {
 public:
  explicit Places(Visit visit) : visit_(std::move(visit)) {}

  void project(const plcopen::Project& project) {
    for (const plcopen::DataType& type : project.data_types) {
      visit_(type.at);
      spec(type.type);
    }
    for (const plcopen::Pou& one : project.pous) pou(one);
    for (const plcopen::Pou& one : project.tests) pou(one);
    for (const plcopen::Configuration& one : project.configurations) configuration(one);
  }

 private:
  void spec(const plcopen::TypeSpec& type) {
    variables(type.members);
    for (const plcopen::EnumValue& value : type.values) visit_(value.at);
    if (type.base) spec(*type.base);
  }
  void variables(const std::vector<plcopen::Variable>& list) {
    for (const plcopen::Variable& one : list) {
      visit_(one.at);
      spec(one.type);
    }
  }
  void pou(const plcopen::Pou& pou) {
    visit_(pou.at);
    variables(pou.variables);
    for (const plcopen::Body& body : pou.bodies) visit_(body.at);
    for (const plcopen::Pou& action : pou.actions) this->pou(action);
  }
  void instances(const std::vector<plcopen::PouInstance>& list) {
    for (const plcopen::PouInstance& one : list) visit_(one.at);
  }
  void configuration(const plcopen::Configuration& configuration) {
    if (!configuration.name.empty()) visit_(configuration.at);
    variables(configuration.globals);
    for (const plcopen::Resource& resource : configuration.resources) {
      visit_(resource.at);
      variables(resource.globals);
      for (const plcopen::Task& task : resource.tasks) {
        visit_(task.at);
        instances(task.instances);
      }
      instances(resource.instances);
    }
    variables(configuration.access);
    variables(configuration.configs);
  }

  Visit visit_;
};

}  // namespace

Comments::Comments(const plcopen::Project& project) {
  if (project.comments.empty()) return;
  std::set<Key> declared;
  Places([&](const core::SourceRef& at) {
    if (at.line != 0) declared.insert(key(at));
  }).project(project);
  for (const plcopen::Comment& comment : project.comments) {
    // What CODESYS 2.3 notes for itself.
    if (comment.text.starts_with("(* @")) continue;
    const Key place = key(comment.at);
    const auto next = declared.upper_bound(place);
    if (comment.follows && next != declared.begin()) {
      const auto& [file, line, column] = *std::prev(next);
      if (file == comment.at.file && line == comment.at.line) {
        entries_[*std::prev(next)].after += "  " + comment.text;
        continue;
      }
    }
    if (next != declared.end() && std::get<0>(*next) == comment.at.file) {
      entries_[*next].before.push_back(comment.text);
    } else {
      rest_ += comment.text + "\n";
    }
  }
}

std::string Comments::before(const core::SourceRef& at, std::size_t indent) const {
  const auto found = entries_.find(key(at));
  if (found == entries_.end()) return {};
  std::string text;
  for (const std::string& one : found->second.before) text += std::string(indent, ' ') + one + "\n";
  return text;
}

std::string Comments::after(const core::SourceRef& at) const {
  const auto found = entries_.find(key(at));
  return found == entries_.end() ? std::string() : found->second.after;
}

}  // namespace plc::convert
