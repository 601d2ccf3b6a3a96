// Another program for the plant: calls of the subject "program" that change which one runs.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "bytecode/image.h"
#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/program_json.h"
#include "engineering/subjects.h"

namespace plc::engineering {
namespace {

using namespace field;
using core::Code;

constexpr const char* kNoFolder = "start plc-run with --state DIR, or give [retain] state in plc.toml";

/// The store; or a refusal, and null.
ProgramStore* store_of(Context& context, Answer& answer) {
  ProgramStore* const store = context.program == nullptr ? nullptr : context.program->store;
  if (store == nullptr)
    answer.refuse(409, Code::P7753, "there is no folder in which a program could be kept", {}, kNoFolder);
  return store;
}

constexpr Field kUploadRequest[] = {
    file("image", "The image, as plc compile writes it"),
    optional(
        text("signature", "Ed25519 signature of the image, as plc sign makes it: 128 hexadecimal digits", 128, 128)),
};
constexpr Field kUploadAnswer[] = {
    record("program", kStoredProgram, "It waits for program.start"),
    text("signer", "Name of the key that has signed it; empty: it was not asked"),
};

void upload(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  ProgramStore* const store = store_of(context, answer);
  if (store == nullptr) return;
  const ProgramControl& control = *context.program;
  const auto& bytes = request["image"].get_ref<const std::string&>();
  const std::string signature = request.value("signature", "");
  std::string signer;
  if (control.wants_signature) {
    const PublicKey* const key = signer_of(control.keys, bytes, signature);
    if (key == nullptr) {
      return answer.refuse(
          409, Code::P7751,
          signature.empty() ? "the image is not signed" : "none of the keys of this plant has signed the image",
          "signature",
          "plc sign IMAGE --key NAME.key; keys under [engineering] in plc.toml say whose images are taken");
    }
    signer = key->name;
  }
  const auto ends = [&] {
    answer.refuse(409, Code::P7755, "nothing is uploaded now: another program starts, or plc-run ends");
  };
  if (control.ending) return ends();
  auto stored = store->put(bytes, caller.user, context.calendar.utc_ns(), [&](const std::string& file) {
    return control.check ? control.check(file) : std::string();
  });
  if (!stored) {
    if (control.ending) return ends();
    return answer.refuse(stored.error(), stored.error().code == Code::P7750 ? "image" : "");
  }
  context.audit.add(caller.user, caller.address, "program.upload", {{"image", stored->image}, {"signer", signer}});
  answer.body() = {{"program", program_json(*stored)}, {"signer", signer}};
}

constexpr Field kProjectRequest[] = {
    file("project", "The project from which the image was made: a file, or an archive"),
    text("name", "Under which program.project gives it", 1, 200),
};
constexpr Field kProjectAnswer[] = {record("program", kStoredProgram, "To which it belongs")};

void store_project(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  ProgramStore* const store = store_of(context, answer);
  if (store == nullptr) return;
  const std::string name = request["name"];
  if (name.find_first_of("/\\\"") != std::string::npos || name.front() == '.') {
    return answer.refuse(400, Code::P7714, "must be the name of a file, without folders", "name");
  }
  const auto& bytes = request["project"].get_ref<const std::string&>();
  const auto stored = store->put_project(bytes, name);
  if (!stored) return answer.refuse(stored.error());
  context.audit.add(caller.user, caller.address, "program.store_project",
                    {{"image", stored->image}, {"name", name}, {"bytes", bytes.size()}});
  answer.body() = {{"program", program_json(*stored)}};
}

/// Refused when the program forbids it, or something else is under way.
bool may_ask(Context& context, bool start, Answer& answer) {
  if (context.no_program != nullptr && context.no_program->holds()) {
    answer.refuse(409, Code::P7756, context.no_program->path() + " is TRUE: no program is started or stopped now");
    return false;
  }
  if (context.program->may_ask(start)) return true;
  answer.refuse(409, Code::P7755, "nothing can be started or stopped now: another program starts, or plc-run ends");
  return false;
}

/// Likewise; else it is a wish from now on.
bool ask(Context& context, ProgramControl::Wish wish, Answer& answer) {
  if (!may_ask(context, wish.start, answer)) return false;
  if (context.program->ask(std::move(wish))) return true;
  answer.refuse(409, Code::P7755, "nothing can be started or stopped now: something else is under way");
  return false;
}

constexpr Field kStartRequest[] = {
    optional(choice("kind", "warm|cold",
                    "warm: retained variables keep their values; cold: PERSISTENT ones alone; default warm")),
    optional(text("image", "SHA-256 of the image that is meant: refused when it is another one", 64, 64)),
};
constexpr Field kStartAnswer[] = {text("image", "SHA-256 of the image that starts")};

void start(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  ProgramControl* const control = context.program;
  const std::string kind = request.value("kind", "warm");
  // Without a folder users would be gone, too.
  ProgramStore* const store = store_of(context, answer);
  if (store == nullptr) return;
  const auto waits = store->waiting();
  const std::string image = waits ? waits->image : context.identity.image_hash;
  if (request.contains("image") && request["image"] != image) {
    return answer.refuse(409, Code::P7755, "the program that would start is " + image, "image");
  }
  // WHY before the files: they let go of the program that a trial would give way to.
  if (!may_ask(context, true, answer)) return;
  // The wish comes after the files: with a loss of power between, the next start takes the new program.
  if (waits) {
    const std::vector<std::byte> running = bytecode::save(context.variables.image());
    StoredProgram now = control->running;
    if (now.image.empty()) now.image = context.identity.image_hash;
    if (const auto problem = store->try_next(image, kind, std::move(now),
                                             {reinterpret_cast<const char*>(running.data()), running.size()},
                                             fingerprint_of(control->given_path))) {
      return answer.refuse(*problem);
    }
  }
  if (!ask(context, {true, kind, caller.user, context.clock.now_ns()}, answer)) {
    if (waits) store->wait_again();
    return;
  }
  context.audit.add(caller.user, caller.address, "program.start", {{"image", image}, {"kind", kind}});
  answer.body()["image"] = image;
}

constexpr Field kStopAnswer[] = {text("image", "SHA-256 of the image that stops")};

void stop(Context& context, const Caller& caller, const Json&, Answer& answer) {
  if (store_of(context, answer) == nullptr) return;
  if (!ask(context, {false, {}, caller.user, context.clock.now_ns()}, answer)) return;
  context.audit.add(caller.user, caller.address, "program.stop", {{"image", context.identity.image_hash}});
  answer.body()["image"] = context.identity.image_hash;
}

constexpr Call kCalls[] = {
    {.name = "program.upload",
     .method = Method::kPost,
     .path = "/api/program/upload",
     .right = Right::kEngineer,
     .doc = "Keeps an image for program.start. It is looked at first, as plc-run --check does: an image that could not "
            "run "
            "here is refused, and nothing changes. Recorded in the audit.",
     .request = kUploadRequest,
     .response = kUploadAnswer,
     .example = R"({"image": "program.image"})",
     .run = upload,
     .thread = Thread::kUpload},
    {.name = "program.store_project",
     .method = Method::kPost,
     .path = "/api/program/store-project",
     .right = Right::kEngineer,
     .doc = "Keeps the project of the image that was uploaded, for program.project. Recorded in the audit.",
     .request = kProjectRequest,
     .response = kProjectAnswer,
     .example = R"({"project": "program.project", "name": "tank.xml"})",
     .run = store_project,
     .thread = Thread::kFiles},
    {.name = "program.stop",
     .method = Method::kPost,
     .path = "/api/program/stop",
     .right = Right::kEngineer,
     .doc = "Ends all tasks; outputs go into their safe state, and Modbus is silent. The engineering server goes on: "
            "program.start starts again, and so does plc-run itself when it is started anew. Recorded in the audit.",
     .response = kStopAnswer,
     .example = R"({})",
     .run = stop,
     .thread = Thread::kFiles},
    {.name = "program.start",
     .method = Method::kPost,
     .path = "/api/program/start",
     .right = Right::kEngineer,
     .doc =
         "Starts the program that was uploaded, or, when none waits, the one that runs once more. The server is away "
         "for "
         "that time, and sessions stay. A program that ends, or has a fault, in its first second is left, and the one "
         "before starts again; `program` says so. Recorded in the audit.",
     .request = kStartRequest,
     .response = kStartAnswer,
     .example = R"({"kind": "warm"})",
     .run = start,
     .thread = Thread::kFiles},
};

}  // namespace

std::span<const Call> upload_calls() { return kCalls; }

}  // namespace plc::engineering
