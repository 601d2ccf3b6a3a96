/* What the C translation of a generated program stands on: IEC 61131-3 arithmetic as docs/guides/values.md,
   conversions.md, events.md and statements.md define it, written anew from those pages. Nothing of the project is
   included here: a mistake in the compiler, the library or the interpreter must not be repeated by what judges them.
   In: operands. Out: results, and `ev` set to 1 where the pages say that an event is counted. C11, -fwrapv. */
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef int8_t i8;
typedef int16_t i16;
typedef int32_t i32;
typedef int64_t i64;
typedef uint8_t u8;
typedef uint16_t u16;
typedef uint32_t u32;
typedef uint64_t u64;
typedef float f32;
typedef double f64;

static u8 ev;        /* an event happened since this was last cleared */
static u64 executed; /* statements */

/* ---- integers: modulo 2^width; the cast back to T does it, since -fwrapv defines everything before it */
#define INTEGERS(T, is_signed)                                       \
  static inline T add_##T(T a, T b) { return (T)(a + b); }           \
  static inline T sub_##T(T a, T b) { return (T)(a - b); }           \
  static inline T mul_##T(T a, T b) { return (T)((u64)a * (u64)b); } \
  static inline T neg_##T(T a) { return (T)(0 - a); }                \
  static inline T abs_##T(T a) { return a < 0 ? (T)(0 - a) : a; }    \
  static inline T div_##T(T a, T b) {                                \
    if (b == 0) {                                                    \
      ev = 1;                                                        \
      return 0;                                                      \
    }                                                                \
    return (is_signed) && b == (T)-1 ? (T)(0 - a) : (T)(a / b);      \
  }                                                                  \
  static inline T mod_##T(T a, T b) { return b == 0 || ((is_signed) && b == (T)-1) ? (T)0 : (T)(a % b); }
INTEGERS(i8, 1)
INTEGERS(i16, 1)
INTEGERS(i32, 1)
INTEGERS(i64, 1)
INTEGERS(u8, 0)
INTEGERS(u16, 0)
INTEGERS(u32, 0)
INTEGERS(u64, 0)

/* ---- reals: IEEE 754, one NaN */
static inline f32 one_f32(f32 v) {
  const u32 quiet = 0x7fc00000u;
  if (isnan(v)) memcpy(&v, &quiet, 4);
  return v;
}
static inline f64 one_f64(f64 v) {
  const u64 quiet = 0x7ff8000000000000ull;
  if (isnan(v)) memcpy(&v, &quiet, 8);
  return v;
}
#define REALS(T)                                                              \
  static inline T add_##T(T a, T b) { return one_##T(a + b); }                \
  static inline T sub_##T(T a, T b) { return one_##T(a - b); }                \
  static inline T mul_##T(T a, T b) { return one_##T(a * b); }                \
  static inline T div_##T(T a, T b) { return one_##T(a / b); }                \
  static inline T neg_##T(T a) { return one_##T(-a); }                        \
  static inline T abs_##T(T a) { return one_##T(signbit(a) ? -a : a); }       \
  static inline T expt_##T(T a, f64 b) { return one_##T((T)pow((f64)a, b)); } \
  static inline T sqrt_##T(T a) { return one_##T((T)sqrt((f64)a)); }          \
  static inline T sin_##T(T a) { return one_##T((T)sin((f64)a)); }            \
  static inline T cos_##T(T a) { return one_##T((T)cos((f64)a)); }            \
  static inline T atan_##T(T a) { return one_##T((T)atan((f64)a)); }          \
  static inline T exp_##T(T a) { return one_##T((T)exp((f64)a)); }            \
  static inline T ln_##T(T a) { return one_##T((T)log((f64)a)); }
REALS(f32)
REALS(f64)

/* ---- comparison and selection: MIN and MAX keep their first input unless the next is really beyond it */
#define ORDERED(T)                                                                   \
  static inline u8 eq_##T(T a, T b) { return a == b; }                               \
  static inline u8 ne_##T(T a, T b) { return a != b; }                               \
  static inline u8 lt_##T(T a, T b) { return a < b; }                                \
  static inline u8 le_##T(T a, T b) { return a <= b; }                               \
  static inline u8 gt_##T(T a, T b) { return a > b; }                                \
  static inline u8 ge_##T(T a, T b) { return a >= b; }                               \
  static inline T min_##T(T a, T b) { return b < a ? b : a; }                        \
  static inline T max_##T(T a, T b) { return b > a ? b : a; }                        \
  static inline T limit_##T(T lo, T v, T hi) { return min_##T(max_##T(v, lo), hi); } \
  static inline T sel_##T(u8 g, T a, T b) { return g ? b : a; }                      \
  static inline T range_##T(T lo, T v, T hi) { return v < lo ? (ev = 1, lo) : v > hi ? (ev = 1, hi) : v; }
ORDERED(i8)
ORDERED(i16)
ORDERED(i32)
ORDERED(i64)
ORDERED(u8)
ORDERED(u16)
ORDERED(u32)
ORDERED(u64)
ORDERED(f32)
ORDERED(f64)

/* ---- bit strings */
#define BITS(T, width)                                                                                    \
  static inline T and_##T(T a, T b) { return a & b; }                                                     \
  static inline T or_##T(T a, T b) { return a | b; }                                                      \
  static inline T xor_##T(T a, T b) { return a ^ b; }                                                     \
  static inline T not_##T(T a) { return (T)~a; }                                                          \
  static inline T shl_##T(T a, i64 n) { return n < 0 ? (ev = 1, a) : n >= width ? 0 : (T)((u64)a << n); } \
  static inline T shr_##T(T a, i64 n) { return n < 0 ? (ev = 1, a) : n >= width ? 0 : (T)((u64)a >> n); } \
  static inline T rol_##T(T a, i64 n) {                                                                   \
    if (n < 0) ev = 1;                                                                                    \
    for (n = n < 0 ? 0 : n % width; n > 0; --n) a = (T)((T)(a << 1) | (a >> (width - 1)));                \
    return a;                                                                                             \
  }                                                                                                       \
  static inline T ror_##T(T a, i64 n) { return n < 0 ? (ev = 1, a) : rol_##T(a, width - n % width); }     \
  static inline T put_##T(T a, unsigned at, unsigned bits, u64 v) {                                       \
    const u64 mask = (~0ull >> (64 - bits)) << at;                                                        \
    return (T)((a & ~mask) | ((v << at) & mask));                                                         \
  }                                                                                                       \
  static inline u64 get_##T(T a, unsigned at, unsigned bits) { return ((u64)a >> at) & (~0ull >> (64 - bits)); }
BITS(u8, 8)
BITS(u16, 16)
BITS(u32, 32)
BITS(u64, 64)
static inline u8 not_bool(u8 a) { return !a; }

/* ---- conversions: reals round half to even and saturate */
#define FROM_REAL(T, low, high, above)                                                 \
  static inline T real_to_##T(f64 v) {                                                 \
    if (isnan(v)) return (ev = 1, 0);                                                  \
    v = nearbyint(v);                                                                  \
    return v < (low) ? (ev = 1, (T)(low)) : v >= (above) ? (ev = 1, (T)(high)) : (T)v; \
  }                                                                                    \
  static inline T trunc_to_##T(f64 v) {                                                \
    if (isnan(v)) return (ev = 1, 0);                                                  \
    v = trunc(v);                                                                      \
    return v < (low) ? (ev = 1, (T)(low)) : v >= (above) ? (ev = 1, (T)(high)) : (T)v; \
  }
FROM_REAL(i8, INT8_MIN, INT8_MAX, 0x1p7)
FROM_REAL(i16, INT16_MIN, INT16_MAX, 0x1p15)
FROM_REAL(i32, INT32_MIN, INT32_MAX, 0x1p31)
FROM_REAL(i64, INT64_MIN, INT64_MAX, 0x1p63)
FROM_REAL(u8, 0, UINT8_MAX, 0x1p8)
FROM_REAL(u16, 0, UINT16_MAX, 0x1p16)
FROM_REAL(u32, 0, UINT32_MAX, 0x1p32)
FROM_REAL(u64, 0, UINT64_MAX, 0x1p64)
static inline f32 real_to_f32(f64 v) { return one_f32((f32)v); }
static inline f64 real_to_f64(f64 v) { return one_f64(v); }
static inline u8 real_to_bool(f64 v) { return isnan(v) ? (ev = 1, 0) : v != 0; }

/* ---- durations and times of day, in ns */
#define MS 1000000ll
static inline i64 ms_of(i64 t) { return t / MS; }
/* Exact to 113 bits, where the library is exact: half to even, then saturated. */
static inline i64 rounded(__float128 v) {
  if (v != v) return (ev = 1, 0);
  if (v >= (__float128)0x1p63 - 0.5) return (ev = 1, INT64_MAX);
  if (v < -(__float128)0x1p63 - 0.5) return (ev = 1, INT64_MIN);
  if (v <= -(__float128)0x1p63) return INT64_MIN;
  const i64 whole = (i64)v;
  const __float128 rest = v - whole;
  if (rest > 0.5 || (rest == 0.5 && whole % 2 != 0)) return whole + 1;
  if (rest < -0.5 || (rest == -0.5 && whole % 2 != 0)) return whole - 1;
  return whole;
}
static inline f32 time_to_f32(i64 t) { return (f32)((__float128)t / MS); }
static inline f64 time_to_f64(i64 t) { return (f64)((__float128)t / MS); }
static inline i64 time_of(i64 ms) { return ms * MS; }
static inline i64 time_of_real(f64 ms) { return rounded((__float128)ms * MS); }
#define DAY 86400000000000ll
static inline i64 in_day(i64 t) { return (t % DAY + DAY) % DAY; }
static inline i64 tod_add(i64 t, i64 by) { return in_day(in_day(t) + by % DAY); }
static inline i64 tod_sub(i64 t, i64 by) { return in_day(in_day(t) - by % DAY); }
static inline i64 time_mul_real(i64 t, f64 by) { return rounded((__float128)t * by); }
static inline i64 time_div_real(i64 t, f64 by) { return by == 0 ? (ev = 1, 0) : rounded((__float128)t / by); }
static inline i64 time_div_u64(i64 t, u64 by) {
  if (by == 0) return (ev = 1, 0);
  const u64 magnitude = t < 0 ? 0 - (u64)t : (u64)t;
  return t < 0 ? (i64)(0 - magnitude / by) : (i64)(magnitude / by);
}

/* ---- strings of either kind: more room than any capacity that occurs */
#define ROOM 600
/* A pointer: its object, its place in it, and how wide the REALs in the object are, if it is made of REALs. */
typedef struct {
  u8* base;
  i64 size, at;
  int real;
} ptr;
static inline ptr ptr_by(ptr p, i64 bytes) {
  p.at = (i64)((u64)p.at + (u64)bytes);
  return p;
}
static inline int ptr_null(ptr p) { return p.base == 0 && p.at == 0; }
static inline int ptr_inside(ptr p, i64 bytes) {
  if (p.base != 0 && p.at >= 0 && p.at <= p.size - bytes) return 1;
  ev = 1;
  return 0;
}
/* There is one NaN. */
static inline f32 one_nan_f32(f32 x) {
  const u32 bits = 0x7fc00000u;
  if (x != x) memcpy(&x, &bits, sizeof x);
  return x;
}
static inline f64 one_nan_f64(f64 x) {
  const u64 bits = 0x7ff8000000000000u;
  if (x != x) memcpy(&x, &bits, sizeof x);
  return x;
}
static inline void ptr_settle(ptr p) {
  for (i64 i = 0; p.real != 0 && i < p.size; i += p.real) {
    if (p.real == 4) {
      f32 x;
      memcpy(&x, p.base + i, sizeof x);
      x = one_nan_f32(x);
      memcpy(p.base + i, &x, sizeof x);
    } else {
      f64 x;
      memcpy(&x, p.base + i, sizeof x);
      x = one_nan_f64(x);
      memcpy(p.base + i, &x, sizeof x);
    }
  }
}
#define POINTER_TO(T, settled)                                        \
  static inline T ptr_get_##T(ptr p) {                                \
    T x = 0;                                                          \
    if (ptr_inside(p, sizeof x)) memcpy(&x, p.base + p.at, sizeof x); \
    return settled(x);                                                \
  }                                                                   \
  static inline void ptr_put_##T(ptr p, T x) {                        \
    if (!ptr_inside(p, sizeof x)) return;                             \
    memcpy(p.base + p.at, &x, sizeof x);                              \
    ptr_settle(p);                                                    \
  }
POINTER_TO(i8, )
POINTER_TO(i16, )
POINTER_TO(i32, )
POINTER_TO(i64, )
POINTER_TO(u8, )
POINTER_TO(u16, )
POINTER_TO(u32, )
POINTER_TO(u64, )
POINTER_TO(f32, one_nan_f32)
POINTER_TO(f64, one_nan_f64)

typedef struct {
  u16 n;
  u16 d[ROOM];
} str;
static inline str str_of(u16 n, const u16* d) {
  str s;
  s.n = n;
  memset(s.d, 0, sizeof s.d);
  memcpy(s.d, d, n * sizeof *d);
  return s;
}
static inline str str_fit(str s, u16 capacity) {
  if (s.n > capacity) {
    s.n = capacity;
    ev = 1;
  }
  return s;
}
static inline str str_part(str s, i64 at, i64 length) { /* 0 <= at <= n; length is cut */
  if (length > s.n - at) length = s.n - at;
  return str_of((u16)length, s.d + at);
}
static inline str str_join(str a, str b) {
  memcpy(a.d + a.n, b.d, b.n * sizeof *b.d);
  a.n = (u16)(a.n + b.n);
  return a;
}
static inline i64 str_length(i64 n) { return n < 0 ? (ev = 1, 0) : n; }
static inline str str_left(str s, i64 n) { return str_part(s, 0, str_length(n)); }
static inline str str_right(str s, i64 n) {
  n = str_length(n);
  return n >= s.n ? s : str_part(s, s.n - n, n);
}
static inline str str_mid(str s, i64 n, i64 p) {
  n = str_length(n);
  return p < 1 || p > s.n ? (ev = 1, str_part(s, 0, 0)) : str_part(s, p - 1, n);
}
static inline str str_insert(str a, str b, i64 p) {
  if (p < 0 || p > a.n) return (ev = 1, a);
  return str_join(str_join(str_part(a, 0, p), b), str_part(a, p, a.n));
}
static inline str str_replace(str a, str b, i64 n, i64 p) {
  n = str_length(n);
  if (p < 1 || p > a.n) return (ev = 1, a);
  const i64 behind = n > a.n - (p - 1) ? a.n : p - 1 + n;
  return str_join(str_join(str_part(a, 0, p - 1), b), str_part(a, behind, a.n));
}
static inline str str_delete(str s, i64 n, i64 p) {
  n = str_length(n);
  if (p < 1 || p > s.n) return (ev = 1, s);
  const i64 behind = n > s.n - (p - 1) ? s.n : p - 1 + n;
  return str_join(str_part(s, 0, p - 1), str_part(s, behind, s.n));
}
static inline i16 str_len(str s) { return (i16)s.n; }
static inline i16 str_find(str a, str b) {
  for (int at = 0; b.n > 0 && at + b.n <= a.n; ++at) {
    if (memcmp(a.d + at, b.d, b.n * sizeof *b.d) == 0) return (i16)(at + 1);
  }
  return 0;
}
static inline int str_order(str a, str b) {
  for (int i = 0; i < a.n && i < b.n; ++i) {
    if (a.d[i] != b.d[i]) return a.d[i] < b.d[i] ? -1 : 1;
  }
  return (a.n > b.n) - (a.n < b.n);
}
static inline u8 eq_str(str a, str b) { return str_order(a, b) == 0; }
static inline u8 ne_str(str a, str b) { return str_order(a, b) != 0; }
static inline u8 lt_str(str a, str b) { return str_order(a, b) < 0; }
static inline u8 le_str(str a, str b) { return str_order(a, b) <= 0; }
static inline u8 gt_str(str a, str b) { return str_order(a, b) > 0; }
static inline u8 ge_str(str a, str b) { return str_order(a, b) >= 0; }
static inline str sel_str(u8 g, str a, str b) { return g ? b : a; }
static inline str min_str(str a, str b) { return str_order(b, a) < 0 ? b : a; }
static inline str max_str(str a, str b) { return str_order(b, a) > 0 ? b : a; }
static inline str str_of_number(u64 v, int minus) {
  u16 digits[24];
  int at = 24;
  do {
    digits[--at] = (u16)('0' + v % 10);
    v /= 10;
  } while (v != 0);
  if (minus) digits[--at] = '-';
  return str_of((u16)(24 - at), digits + at);
}
static inline str str_of_unsigned(u64 v) { return str_of_number(v, 0); }
static inline str str_of_signed(i64 v) { return v < 0 ? str_of_number(0 - (u64)v, 1) : str_of_number((u64)v, 0); }
