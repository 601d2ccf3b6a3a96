image 7
project "parts"
product "PICARD 0.1.0"
options drawing none separate wait-free auto ""
file "parts.st"
type 0 struct size 0 align 1 name "#globals"
type 1 scalar POINTER
type 2 scalar INT
type 3 scalar POINTER
type 4 scalar POINTER
type 5 scalar POINTER
type 6 scalar POINTER
type 7 scalar REAL
type 8 struct size 56 align 8 name "Walk"
  field "p" t1 at 0 input
  field "i" t2 at 8 input
  field "q" t3 at 16 local
  field "t" t4 at 24 local
  field "c" t5 at 32 local
  field "b" t6 at 40 local
  field "sum" t7 at 48 local
type 9 array t7 4 from 0
type 10 string STRING 9 align 2
type 11 scalar BOOL
type 12 struct size 36 align 4 name "Part"
  field "n" t2 at 0 member
  field "a" t9 at 4 member
  field "t" t10 at 20 member
  field "b" t11 at 34 member
type 13 scalar LINT
type 14 string STRING 3 align 2
type 15 scalar BYTE
type 16 struct size 48 align 8
  field "#t0" t7 at 0 hidden
  field "#t1" t7 at 4 hidden
  field "#t2" t1 at 8 hidden
  field "#t3" t13 at 16 hidden
  field "#t4" t13 at 24 hidden
  field "#t5" t5 at 32 hidden
  field "#t6" t11 at 40 hidden
  field "#t7" t11 at 41 hidden
type 17 array t12 3 from 0
type 18 struct size 176 align 8 name "Main"
  field "parts" t17 at 0 local
  field "w" t8 at 112 local
  field "i" t2 at 168 local
type 19 struct size 0 align 1
type 20 struct size 0 align 1
type 21 struct size 176 align 8 name "Cyclic"
  field "main" t18 at 0 member
type 22 struct size 48 align 8 name "#constants"
  field "#c0" t7 at 0 member constant
  field "#c1" t13 at 8 member constant
  field "#c2" t13 at 16 member constant
  field "#c3" t14 at 24 member constant
  field "#c4" t13 at 32 member constant
  field "#c5" t15 at 40 member constant
  field "#c6" t2 at 42 member constant
  field "#c7" t2 at 44 member constant
globals 0
constants 22
  init #c0 = 1.5
  init #c1 = 4
  init #c3 = "abc"
  init #c4 = 1
  init #c5 = 65
  init #c6 = 1
  init #c7 = 5
function "INT_TO_LINT:INT,LINT"
pou "Walk" block instance t8 frame t16
  debug 0 file 0 line 5 column 1 id -1 kind 21
    ADR_PTR i:q, i:p, t12, .1, [i:i]
  debug 8 file 0 line 6 column 1 id -1 kind 21
    LOAD_PTR f:#t0, i:q, t7
    ADD_F32 f:#t1, f:#t0, c:#c0
    STORE_PTR i:q, f:#t1, t7
  debug 20 file 0 line 7 column 1 id -1 kind 21
    ADD_64 i:q, i:q, c:#c1
  debug 24 file 0 line 8 column 1 id -1 kind 21
    LOAD_PTR f:#t1, i:q, t7
    ADD_F32 f:#t0, i:sum, f:#t1
    ADD_64 f:#t2, i:p, c:#c2
    LOAD_PTR f:#t1, f:#t2, t12, .1, [i:i]
    ADD_F32 i:sum, f:#t0, f:#t1
  debug 48 file 0 line 9 column 1 id -1 kind 21
    ADR_PTR i:t, i:p, t12, .2
  debug 54 file 0 line 10 column 1 id -1 kind 21
    STORE_PTR i:t, c:#c3, t10
  debug 58 file 0 line 11 column 1 id -1 kind 21
    ADR_PTR i:c, i:p, t12, .2
  debug 64 file 0 line 12 column 1 id -1 kind 21
    CALL_STD s0, f:#t3, i:i  ; "INT_TO_LINT:INT,LINT"
    MUL_64 f:#t4, f:#t3, c:#c4
    ADD_64 f:#t5, i:c, f:#t4
    STORE_PTR f:#t5, c:#c5, t15
  debug 80 file 0 line 13 column 1 id -1 kind 21
    ADR_PTR i:b, i:p, t12, .3
  debug 86 file 0 line 14 column 1 id -1 kind 21
    LOAD_PTR f:#t6, i:b, t11
    BOOL_RUN
      | 0x55555555 f:#t7, f:#t6, f:#t6, f:#t6, f:#t6, f:#t6
    STORE_PTR i:b, f:#t7, t11
    RETURN
pou "Main" program instance t18 frame t19
  debug 0 file 0 line 18 column 1 id -1 kind 21
    ADD_16 i:i, i:i, c:#c6
  debug 4 file 0 line 19 column 1 id -1 kind 21
    ADR_AT i:w.p, i:parts[1], t12
    MOD_I16 i:w.i, i:i, c:#c7
    CALL_POU p0, i:w  ; "Walk"
    RETURN
pou "Cyclic" task instance t21 frame t20
  debug 0 file 0 line 24 column 9 id -1 kind 19
    CALL_POU p1, i:main  ; "Main"
  debug 3 file 0 line 23 column 6 id -1 kind 18
    RETURN
task "Cyclic" period 20000000 priority 0 single "" body p2
