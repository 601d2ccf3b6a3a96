// The page of a project that has no pages.toml: made from its addresses, its globals and the units of its taskblocks.
//
// In: variables. Out: a document, in which every element is where there is place. Threads: kIo. Does not belong here:
// how elements look.
#pragma once

#include "engineering/variables.h"
#include "hmi/document.h"

namespace plc::engineering {

hmi::Document first_page(const Variables& variables, const std::string& title);

}  // namespace plc::engineering
