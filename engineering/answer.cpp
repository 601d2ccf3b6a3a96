#include "engineering/answer.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace plc::engineering {

Answer::Answer() : body_(std::make_unique<Json>(Json::object())) {}
Answer::~Answer() = default;

void Answer::give_file(std::string bytes, std::string name) {
  file_ = std::move(bytes);
  file_name_ = std::move(name);
}

void Answer::give_picture(std::string bytes, std::string type) {
  file_ = std::move(bytes);
  file_type_ = std::move(type);
}

void Answer::refuse(int status, core::Code code, std::string text, std::string field, std::string help) {
  refuse(Refusal{status, code, std::move(text), std::move(field), std::move(help), 0});
}

void Answer::refuse(const core::Problem& problem, std::string field) {
  const int status = problem.code == core::Code::P7101 ? 404 : 409;
  refuse(status, problem.code, problem.message, std::move(field), problem.help);
}

void Answer::refuse(Refusal refusal) {
  refused_ = true;
  refusal_ = std::move(refusal);
}

void Answer::set_cookie(std::string secret) {
  sets_cookie_ = true;
  cookie_ = std::move(secret);
}

}  // namespace plc::engineering
