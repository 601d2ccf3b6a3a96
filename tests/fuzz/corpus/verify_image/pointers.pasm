image 7
project "project"
product "PICARD 0.1.0"
options drawing none separate wait-free auto ""
file "tests/cases/st/pointers/project.st"
type 0 struct size 0 align 1 name "#globals"
type 1 struct size 0 align 1
type 2 scalar DINT
type 3 scalar POINTER
type 4 scalar INT
type 5 scalar BOOL
type 6 scalar LINT
type 7 struct size 56 align 8
  field "Sum" t2 at 0 return
  field "first" t3 at 8 input
  field "count" t4 at 16 input
  field "i" t4 at 18 local
  field "#t0" t4 at 20 hidden
  field "#t1" t5 at 22 hidden
  field "#t2" t6 at 24 hidden
  field "#t3" t6 at 32 hidden
  field "#t4" t3 at 40 hidden
  field "#t5" t4 at 48 hidden
  field "#t6" t2 at 52 hidden
type 8 ref t4
type 9 struct size 24 align 8
  field "Double" t4 at 0 return
  field "x" t8 at 8 inout
  field "#t0" t4 at 16 hidden
  field "#t1" t4 at 18 hidden
type 10 array t4 4 from 1
type 11 scalar POINTER
type 12 struct size 16 align 8 name "Link"
  field "value" t4 at 0 member
  field "next" t11 at 8 member
type 13 array t3 2 from 0
type 14 scalar POINTER
type 15 array t4 3 from 0
type 16 array t15 2 from 0
type 17 scalar POINTER
type 18 struct size 192 align 8 name "Test"
  field "a" t10 at 0 local
  field "p" t3 at 8 local
  field "q" t3 at 16 local
  field "none" t5 at 24 local
  field "is_null" t5 at 25 local
  field "less" t5 at 26 local
  field "same" t5 at 27 local
  field "bytes" t2 at 28 local
  field "third" t4 at 32 local
  field "moved" t4 at 34 local
  field "back" t4 at 36 local
  field "sum" t2 at 40 local
  field "one" t12 at 48 local
  field "two" t12 at 64 local
  field "second" t4 at 80 local
  field "many" t13 at 88 local
  field "pp" t14 at 104 local
  field "through" t4 at 112 local
  field "matrix" t16 at 114 local
  field "pm" t17 at 128 local
  field "i" t4 at 136 local
  field "begins" t3 at 144 local
  field "started" t4 at 152 local
  field "twice" t4 at 154 local
  field "whole" t12 at 160 local
  field "pl" t11 at 176 local
  field "#refs.26" t5 at 184 hidden internal
type 19 struct size 32 align 8
  field "#t0" t3 at 0 hidden
  field "#t1" t6 at 8 hidden
  field "#t2" t14 at 16 hidden
  field "#t3" t8 at 24 hidden
type 20 struct size 192 align 8 name "Cyclic"
  field "main" t18 at 0 member
type 21 struct size 96 align 8 name "#constants"
  field "#c0" t4 at 0 member constant
  field "#c1" t4 at 2 member constant
  field "#c2" t6 at 8 member constant
  field "#c3" t4 at 16 member constant
  field "#c4" t3 at 24 member constant
  field "#c5" t4 at 32 member constant
  field "#c6" t6 at 40 member constant
  field "#c7" t6 at 48 member constant
  field "#c8" t4 at 56 member constant
  field "#c9" t4 at 58 member constant
  field "#c10" t11 at 64 member constant
  field "#c11" t4 at 72 member constant
  field "#c12" t6 at 80 member constant
  field "#c13" t4 at 88 member constant
  field "#c14" t4 at 90 member constant
globals 0
constants 21
  init #c0 = 1
  init #c2 = 2
  init #c3 = 2
  init #c5 = 11
  init #c6 = 4
  init #c7 = 6
  init #c8 = 3
  init #c9 = 22
  init #c11 = 44
  init #c12 = 8
  init #c13 = 21
  init #c14 = 12
function "INT_TO_LINT:INT,LINT"
function "INT_TO_DINT:INT,DINT"
function "LINT_TO_DINT:LINT,DINT"
pou "Sum" function instance t1 frame t7
  debug 0 file 0 line 12 column 3 id -1 kind 21
    SUB_16 f:#t0, f:count, c:#c0
    MOVE_16 f:i, c:#c1
    LE_I16 f:#t1, c:#c1, f:#t0
    COND_JUMP f:#t1, L55
  debug 14 file 0 line 13 column 5 id -1 kind 21
L14:
    CALL_STD s0, f:#t2, f:i  ; "INT_TO_LINT:INT,LINT"
    MUL_64 f:#t3, f:#t2, c:#c2
    ADD_64 f:#t4, f:first, f:#t3
    LOAD_PTR f:#t5, f:#t4, t4
    CALL_STD s1, f:#t6, f:#t5  ; "INT_TO_DINT:INT,DINT"
    ADD_32 f:Sum, f:Sum, f:#t6
  debug 38 file 0 line 12 column 3 id -1 kind 21
    LT_I16 f:#t1, f:i, f:#t0
    COND_JUMP f:#t1, L51
    ADD_16 f:i, f:i, c:#c0
    LOOP_JUMP L14
L51:
    ADD_16 f:i, f:i, c:#c0
L55:
    RETURN
pou "Double" function instance t1 frame t9
  debug 0 file 0 line 19 column 3 id -1 kind 21
    LOAD_VIA f:#t0, f:x, t4
    MUL_16 f:#t1, f:#t0, c:#c3
    STORE_VIA f:x, f:#t1, t4
  debug 12 file 0 line 20 column 3 id -1 kind 21
    LOAD_VIA f:Double, f:x, t4
    RETURN
pou "Test" program instance t18 frame t19
  instance a[0] = 10
  instance a[1] = 20
  instance a[2] = 30
  instance a[3] = 40
  instance one.value = 1
  instance two.value = 2
  instance i = 1
  debug 0 file 0 line 23 column 9 id -1 kind 0
    JUMP_IF i+184, L15
  debug 3 file 0 line 40 column 32 id -1 kind 21
    ADR_AT i:begins, i:i, t4
    BOOL_RUN
      | 0xffffffff i+184, i+184, i+184, i+184, i+184, i+184
  debug 15 file 0 line 46 column 3 id -1 kind 21
L15:
    EQ_64 i:none, i:p, c:#c4
  debug 19 file 0 line 47 column 3 id -1 kind 21
    LOAD_PTR i:started, i:begins, t4
  debug 23 file 0 line 48 column 3 id -1 kind 21
    ADR_AT i:p, i:a, t10
  debug 27 file 0 line 49 column 3 id -1 kind 21
    STORE_PTR i:p, c:#c5, t4
  debug 31 file 0 line 50 column 3 id -1 kind 21
    ADD_64 f:#t0, i:p, c:#c6
    LOAD_PTR i:third, f:#t0, t4
  debug 39 file 0 line 51 column 3 id -1 kind 21
    ADD_64 i:q, i:p, c:#c7
  debug 43 file 0 line 52 column 3 id -1 kind 21
    LOAD_PTR i:moved, i:q, t4
  debug 47 file 0 line 53 column 3 id -1 kind 21
    SUB_64 i:q, i:q, c:#c2
  debug 51 file 0 line 54 column 3 id -1 kind 21
    LOAD_PTR i:back, i:q, t4
  debug 55 file 0 line 55 column 3 id -1 kind 21
    SUB_64 f:#t1, i:q, i:p
    CALL_STD s2, i:bytes, f:#t1  ; "LINT_TO_DINT:LINT,DINT"
  debug 63 file 0 line 56 column 3 id -1 kind 21
    LT_U64 i:less, i:p, i:q
  debug 67 file 0 line 57 column 3 id -1 kind 21
    ADR_AT f:#t0, i:a[2], t4
    EQ_64 i:same, i:q, f:#t0
  debug 75 file 0 line 58 column 3 id -1 kind 21
    ADR_AT f:#t0, i:a[1], t4
    CALL_FN p0, 1=f:#t0, 2=c:#c8, 0=i:sum  ; "Sum"
  debug 87 file 0 line 59 column 3 id -1 kind 21
    ADR_AT i:one.next, i:two, t12
  debug 91 file 0 line 60 column 3 id -1 kind 21
    LOAD_PTR i:second, i:one.next, t12, .0
  debug 97 file 0 line 61 column 3 id -1 kind 21
    STORE_PTR i:one.next, c:#c9, t12, .0
  debug 103 file 0 line 62 column 3 id -1 kind 21
    EQ_64 i:is_null, i:two.next, c:#c10
  debug 107 file 0 line 63 column 3 id -1 kind 21
    ADR_AT i:many[0], i:a[0], t4
  debug 111 file 0 line 64 column 3 id -1 kind 21
    ADR_AT i:many[1], i:a[3], t4
  debug 115 file 0 line 65 column 3 id -1 kind 21
    LOAD_AT f:#t0, i:many, t13, [i:i]
    STORE_PTR f:#t0, c:#c11, t4
  debug 125 file 0 line 66 column 3 id -1 kind 21
    ADR_AT i:pp, i:many[0], t3
  debug 129 file 0 line 67 column 3 id -1 kind 21
    LOAD_PTR f:#t0, i:pp, t3
    LOAD_PTR i:through, f:#t0, t4
  debug 137 file 0 line 68 column 3 id -1 kind 21
    ADD_64 f:#t2, i:pp, c:#c12
    ADR_AT f:#t0, i:a[1], t4
    STORE_PTR f:#t2, f:#t0, t3
  debug 149 file 0 line 69 column 3 id -1 kind 21
    STORE_PTR i:many[1], c:#c13, t4
  debug 153 file 0 line 70 column 3 id -1 kind 21
    ADR_AT i:pm, i:matrix, t16
  debug 157 file 0 line 71 column 3 id -1 kind 21
    STORE_PTR i:pm, c:#c14, t16, [i:i], [2]
  debug 165 file 0 line 72 column 3 id -1 kind 21
    REF_PTR f:#t3, i:many[1], t4
    CALL_FN p1, 1=f:#t3, 0=i:twice  ; "Double"
  debug 175 file 0 line 73 column 3 id -1 kind 21
    MOVE_64 i:pl, i:one.next
  debug 178 file 0 line 74 column 3 id -1 kind 21
    LOAD_PTR i:whole, i:pl, t12
  debug 182 file 0 line 75 column 3 id -1 kind 21
    STORE_PTR i:pl, i:one, t12
    RETURN
pou "Cyclic" task instance t20 frame t1
  instance main.a[0] = 10
  instance main.a[1] = 20
  instance main.a[2] = 30
  instance main.a[3] = 40
  instance main.one.value = 1
  instance main.two.value = 2
  instance main.i = 1
  debug 0 file 0 line 81 column 13 id -1 kind 19
    CALL_POU p2, i:main  ; "Test"
  debug 3 file 0 line 80 column 10 id -1 kind 18
    RETURN
task "Cyclic" period 10000000 priority 1 single "" body p3
