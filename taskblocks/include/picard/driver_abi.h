// What a driver library and the runtime say to each other: plain C, so that compilers, standard libraries and versions
// may differ on both sides. Authors of drivers use driver.h, which fills all of this in.
//
// A library exports one function, picard_driver_library_v1(). What it returns lives as long as the library is loaded
// and never changes. A PICARD_DRIVER_ABI_VERSION that is not the runtime's is refused.
#ifndef PICARD_DRIVER_ABI_H
#define PICARD_DRIVER_ABI_H

/* NOLINTBEGIN(modernize-*): C */

#include "picard/abi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PICARD_DRIVER_ABI_VERSION 1u
#define PICARD_DRIVER_ENTRY "picard_driver_library_v1"

enum picard_key_kind {
  PICARD_KEY_BOOLEAN = 0,
  PICARD_KEY_INTEGER = 1,  /* lowest..highest */
  PICARD_KEY_TEXT = 2,     /* one line */
  PICARD_KEY_CHOICE = 3,   /* one of choices */
  PICARD_KEY_DURATION = 4, /* shortest..longest */
};
enum picard_applies { PICARD_INPUTS = 1, PICARD_OUTPUTS = 2, PICARD_BOTH = 3 };

/* A key of plc.toml that drivers of this kind, or their channels, have. */
struct picard_key {
  const char* name;
  uint32_t kind;    /* picard_key_kind */
  uint32_t applies; /* picard_applies, of channels */
  int64_t lowest;
  int64_t highest;
  const char* choices;       /* "slow|fast" */
  const char* shortest;      /* "1ms" */
  const char* longest;       /* "1h" */
  const char* otherwise;     /* the value without the key, as TOML writes it; null: the key is required */
  const char* example;       /* a value for who must choose one, as TOML writes it, or "" */
  const char* documentation; /* sentences */
};

/* A value of a key, in the order of the keys. */
struct picard_setting {
  const char* text; /* as in the file, or the default */
  int64_t number;   /* true as 1, whole numbers, durations in ns, choices by their position from 0; 0 of texts */
};

/* One line of [inputs] or [outputs]. */
struct picard_channel {
  const char* variable;
  const struct picard_setting* settings; /* of channel_keys */
};

/* One [drivers.NAME]. The structure and all it points to live as long as the object. */
struct picard_driver_config {
  const char* name;
  const char* folder;                    /* of plc.toml: relative files begin there */
  const struct picard_setting* settings; /* of driver_keys */
  const struct picard_channel* inputs;
  uint32_t input_count;
  const struct picard_channel* outputs;
  uint32_t output_count;
};

/* A kind of driver: `kind` in plc.toml. Of each function but create() and destroy(): 0 = it failed, and `failure` says
 * why. All of them may wait; they are called by one thread at a time. */
struct picard_driver_kind {
  const char* name;    /* "ads1115": letters, digits, _ and - */
  const char* summary; /* one sentence */
  const char* example; /* NAME of the driver that `plc config init` writes */
  const char* device;  /* the driver key that says which device, or "" */
  const struct picard_key* driver_keys;
  uint32_t driver_key_count;
  const struct picard_key* channel_keys;
  uint32_t channel_key_count;
  /* Makes an object; null when the settings do not go together. Touches no device. */
  void* (*create)(const struct picard_driver_config* config, struct picard_failure* failure);
  /* Takes the device. After a failure, and after close(), it is called again. */
  int (*open)(void* object, struct picard_failure* failure);
  /* Reads all inputs: values[i] of input i. BOOL: 0 is FALSE. Not called without inputs. */
  int (*read)(void* object, double* values, struct picard_failure* failure);
  /* Writes all outputs. Also the safe values, by another process than the one that ran (a copy of it as it was after
   * open()), when that one has died. Not called without outputs. */
  int (*write)(void* object, const double* values, struct picard_failure* failure);
  /* Gives the device back. After each open(), whether that failed or not. */
  void (*close)(void* object);
  void (*destroy)(void* object);
};

struct picard_driver_library {
  uint32_t abi_version; /* PICARD_DRIVER_ABI_VERSION */
  uint32_t kind_bytes;  /* sizeof(struct picard_driver_kind) */
  uint32_t key_bytes;   /* sizeof(struct picard_key) */
  uint32_t kind_count;
  const struct picard_driver_kind* kinds;
  const char* name;    /* "ads1115" */
  const char* version; /* "1.0.0" */
};

typedef const struct picard_driver_library* (*picard_driver_entry)(void);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-*) */

#endif
