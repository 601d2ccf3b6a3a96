// Assembly: that of the processor this is compiled for.
#pragma once

#if defined(__x86_64__)
#include "native/x86_64/assembly.h"
#elif defined(__aarch64__)
#include "native/aarch64/assembly.h"
#endif
