image 7
project "project"
product "PICARD 0.1.0"
options drawing none separate wait-free auto ""
file "tests/cases/st/pointers-reach-bytes/project.st"
type 0 struct size 0 align 1 name "#globals"
type 1 scalar BYTE
type 2 array t1 8 from 0
type 3 scalar POINTER
type 4 scalar POINTER
type 5 scalar DWORD
type 6 scalar WORD
type 7 scalar REAL
type 8 scalar POINTER
type 9 scalar TIME
type 10 scalar BOOL
type 11 struct size 32 align 8 name "Record"
  field "b" t1 at 0 member
  field "w" t6 at 2 member
  field "d" t5 at 4 member
  field "r" t7 at 8 member
  field "t" t9 at 16 member
  field "f" t10 at 24 member
type 12 scalar POINTER
type 13 array t1 20 from 0
type 14 scalar INT
type 15 scalar INT limits 0 100 name "Percent"
type 16 scalar POINTER
type 17 struct size 176 align 8 name "Test"
  field "bytes" t2 at 0 local
  field "pd" t3 at 8 local
  field "pw" t4 at 16 local
  field "low" t5 at 24 local
  field "high" t5 at 28 local
  field "odd" t6 at 32 local
  field "r" t7 at 36 local
  field "bits" t5 at 40 local
  field "float" t7 at 44 local
  field "pr" t8 at 48 local
  field "rec" t11 at 56 local
  field "pb" t12 at 88 local
  field "image" t13 at 96 local
  field "i" t14 at 116 local
  field "flag" t10 at 118 local
  field "limited" t15 at 120 local
  field "pi" t16 at 128 local
  field "copy" t11 at 136 local
  field "nan" t7 at 168 local
  field "nan_bits" t5 at 172 local
type 18 scalar LINT
type 19 scalar POINTER
type 20 struct size 48 align 8
  field "#t0" t3 at 0 hidden
  field "#t1" t19 at 8 hidden
  field "#t2" t18 at 16 hidden
  field "#t3" t18 at 24 hidden
  field "#t4" t12 at 32 hidden
  field "#t5" t1 at 40 hidden
  field "#t6" t10 at 41 hidden
type 21 struct size 0 align 1
type 22 struct size 176 align 8 name "Cyclic"
  field "main" t17 at 0 member
type 23 struct size 56 align 8 name "#constants"
  field "#c0" t18 at 0 member constant
  field "#c1" t18 at 8 member constant
  field "#c2" t6 at 16 member constant
  field "#c3" t5 at 20 member constant
  field "#c4" t14 at 24 member constant
  field "#c5" t18 at 32 member constant
  field "#c6" t14 at 40 member constant
  field "#c7" t14 at 42 member constant
  field "#c8" t1 at 44 member constant
  field "#c9" t14 at 46 member constant
  field "#c10" t5 at 48 member constant
globals 0
constants 23
  init #c0 = 4
  init #c1 = 3
  init #c2 = 43707
  init #c3 = 1078530011
  init #c5 = 1
  init #c6 = 19
  init #c7 = 1
  init #c8 = 2
  init #c9 = 300
  init #c10 = 4290847557
function "INT_TO_LINT:INT,LINT"
pou "Test" program instance t17 frame t20
  instance bytes[0] = 17
  instance bytes[1] = 34
  instance bytes[2] = 51
  instance bytes[3] = 68
  instance bytes[4] = 85
  instance bytes[5] = 102
  instance bytes[6] = 119
  instance bytes[7] = 136
  instance r = 1
  instance rec.b = 1
  instance rec.w = 770
  instance rec.d = 117835012
  instance rec.r = 1
  instance rec.t = 258000000
  instance rec.f = 1
  debug 0 file 0 line 33 column 3 id -1 kind 21
    ADR_AT i:pd, i:bytes, t2
  debug 4 file 0 line 34 column 3 id -1 kind 21
    LOAD_PTR i:low, i:pd, t5
  debug 8 file 0 line 35 column 3 id -1 kind 21
    ADD_64 f:#t0, i:pd, c:#c0
    LOAD_PTR i:high, f:#t0, t5
  debug 16 file 0 line 36 column 3 id -1 kind 21
    ADR_AT f:#t1, i:bytes, t2
    ADD_64 i:pw, f:#t1, c:#c1
  debug 24 file 0 line 37 column 3 id -1 kind 21
    LOAD_PTR i:odd, i:pw, t6
  debug 28 file 0 line 38 column 3 id -1 kind 21
    STORE_PTR i:pw, c:#c2, t6
  debug 32 file 0 line 39 column 3 id -1 kind 21
    ADR_AT i:pd, i:r, t7
  debug 36 file 0 line 40 column 3 id -1 kind 21
    LOAD_PTR i:bits, i:pd, t5
  debug 40 file 0 line 41 column 3 id -1 kind 21
    STORE_PTR i:pd, c:#c3, t5
  debug 44 file 0 line 42 column 3 id -1 kind 21
    ADR_AT i:pr, i:bits, t5
  debug 48 file 0 line 43 column 3 id -1 kind 21
    LOAD_PTR i:float, i:pr, t7
  debug 52 file 0 line 44 column 3 id -1 kind 21
    ADR_AT i:pb, i:rec, t11
  debug 56 file 0 line 45 column 3 id -1 kind 21
    MOVE_16 i:i, c:#c4
  debug 59 file 0 line 46 column 5 id -1 kind 21
L59:
    CALL_STD s0, f:#t2, i:i  ; "INT_TO_LINT:INT,LINT"
    MUL_64 f:#t3, f:#t2, c:#c5
    ADD_64 f:#t4, i:pb, f:#t3
    LOAD_PTR f:#t5, f:#t4, t1
    STORE_AT i:image, f:#t5, t13, [i:i]
  debug 81 file 0 line 45 column 3 id -1 kind 21
    LT_I16 f:#t6, i:i, c:#c6
    COND_JUMP f:#t6, L94
    ADD_16 i:i, i:i, c:#c7
    LOOP_JUMP L59
L94:
    ADD_16 i:i, i:i, c:#c7
  debug 98 file 0 line 48 column 3 id -1 kind 21
    ADR_AT i:pb, i:copy, t11
  debug 102 file 0 line 49 column 3 id -1 kind 21
    MOVE_16 i:i, c:#c4
  debug 105 file 0 line 50 column 5 id -1 kind 21
L105:
    LOAD_AT f:#t5, i:image, t13, [i:i]
    STORE_PTR i:pb, f:#t5, t1
  debug 115 file 0 line 51 column 5 id -1 kind 21
    ADD_64 i:pb, i:pb, c:#c5
  debug 119 file 0 line 49 column 3 id -1 kind 21
    LT_I16 f:#t6, i:i, c:#c6
    COND_JUMP f:#t6, L132
    ADD_16 i:i, i:i, c:#c7
    LOOP_JUMP L105
L132:
    ADD_16 i:i, i:i, c:#c7
  debug 136 file 0 line 53 column 3 id -1 kind 21
    ADR_AT i:pb, i:flag, t10
  debug 140 file 0 line 54 column 3 id -1 kind 21
    STORE_PTR i:pb, c:#c8, t1
  debug 144 file 0 line 55 column 3 id -1 kind 21
    ADR_AT i:pi, i:limited, t15
  debug 148 file 0 line 56 column 3 id -1 kind 21
    STORE_PTR i:pi, c:#c9, t14
  debug 152 file 0 line 57 column 3 id -1 kind 21
    ADR_AT i:pd, i:nan, t7
  debug 156 file 0 line 58 column 3 id -1 kind 21
    STORE_PTR i:pd, c:#c10, t5
  debug 160 file 0 line 59 column 3 id -1 kind 21
    LOAD_PTR i:nan_bits, i:pd, t5
    RETURN
pou "Cyclic" task instance t22 frame t21
  instance main.bytes[0] = 17
  instance main.bytes[1] = 34
  instance main.bytes[2] = 51
  instance main.bytes[3] = 68
  instance main.bytes[4] = 85
  instance main.bytes[5] = 102
  instance main.bytes[6] = 119
  instance main.bytes[7] = 136
  instance main.r = 1
  instance main.rec.b = 1
  instance main.rec.w = 770
  instance main.rec.d = 117835012
  instance main.rec.r = 1
  instance main.rec.t = 258000000
  instance main.rec.f = 1
  debug 0 file 0 line 65 column 13 id -1 kind 19
    CALL_POU p0, i:main  ; "Test"
  debug 3 file 0 line 64 column 10 id -1 kind 18
    RETURN
task "Cyclic" period 10000000 priority 1 single "" body p1
