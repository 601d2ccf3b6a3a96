image 7
project "project"
product "PICARD 0.1.0"
options drawing none separate wait-free auto ""
file "tests/cases/st/pointers-stay-in-their-object/project.st"
type 0 struct size 0 align 1 name "#globals"
type 1 scalar INT
type 2 scalar BYTE
type 3 array t2 4 from 0
type 4 ref t1
type 5 scalar POINTER
type 6 scalar POINTER
type 7 scalar POINTER
type 8 scalar POINTER
type 9 scalar DWORD
type 10 scalar BOOL
type 11 struct size 80 align 8 name "Test"
  field "a" t1 at 0 local
  field "b" t3 at 2 local
  field "c" t1 at 6 local
  field "r" t4 at 8 local
  field "p" t5 at 16 local
  field "pd" t6 at 24 local
  field "pi" t7 at 32 local
  field "pr" t8 at 40 local
  field "before" t9 at 48 local
  field "beyond" t9 at 52 local
  field "half" t9 at 56 local
  field "wild" t9 at 60 local
  field "closed" t9 at 64 local
  field "nothing" t1 at 68 local
  field "kept" t1 at 70 local
  field "exact" t1 at 72 local
  field "fixed" t1 at 74 local
  field "k" t1 at 76 local constant
  field "#refs.18" t10 at 78 hidden internal
type 12 scalar LINT
type 13 scalar POINTER
type 14 struct size 32 align 8
  field "#t0" t5 at 0 hidden
  field "#t1" t2 at 8 hidden
  field "#t2" t13 at 16 hidden
  field "#t3" t4 at 24 hidden
type 15 struct size 0 align 1
type 16 struct size 80 align 8 name "Cyclic"
  field "main" t11 at 0 member
type 17 struct size 40 align 8 name "#constants"
  field "#c0" t12 at 0 member constant
  field "#c1" t12 at 8 member constant
  field "#c2" t2 at 16 member constant
  field "#c3" t9 at 20 member constant
  field "#c4" t12 at 24 member constant
  field "#c5" t2 at 32 member constant
  field "#c6" t1 at 34 member constant
globals 0
constants 17
  init #c0 = -1
  init #c1 = 4
  init #c2 = 99
  init #c3 = 4294967295
  init #c4 = 1000000
  init #c5 = 1
  init #c6 = 6
function "BYTE_TO_DWORD:BYTE,DWORD"
pou "Test" program instance t11 frame t14
  instance a = 1
  instance b[0] = 1
  instance b[1] = 2
  instance b[2] = 3
  instance b[3] = 4
  instance c = 3
  instance nothing = 7
  instance k = 5
  debug 0 file 0 line 5 column 9 id -1 kind 0
    JUMP_IF i+78, L15
  debug 3 file 0 line 10 column 23 id -1 kind 21
    REF_AT i:r, i:a, t1
    BOOL_RUN
      | 0xffffffff i+78, i+78, i+78, i+78, i+78, i+78
  debug 15 file 0 line 24 column 3 id -1 kind 21
L15:
    ADR_AT i:p, i:b, t3
  debug 19 file 0 line 25 column 3 id -1 kind 21
    ADD_64 f:#t0, i:p, c:#c0
    LOAD_PTR f:#t1, f:#t0, t2
    CALL_STD s0, i:before, f:#t1  ; "BYTE_TO_DWORD:BYTE,DWORD"
  debug 31 file 0 line 26 column 3 id -1 kind 21
    ADD_64 f:#t0, i:p, c:#c1
    LOAD_PTR f:#t1, f:#t0, t2
    CALL_STD s0, i:beyond, f:#t1  ; "BYTE_TO_DWORD:BYTE,DWORD"
  debug 43 file 0 line 27 column 3 id -1 kind 21
    ADD_64 f:#t0, i:p, c:#c1
    STORE_PTR f:#t0, c:#c2, t2
  debug 51 file 0 line 28 column 3 id -1 kind 21
    ADR_AT i:pd, i:b[1], t2
  debug 55 file 0 line 29 column 3 id -1 kind 21
    LOAD_PTR i:half, i:pd, t9
  debug 59 file 0 line 30 column 3 id -1 kind 21
    STORE_PTR i:pd, c:#c3, t9
  debug 63 file 0 line 31 column 3 id -1 kind 21
    LOAD_PTR i:nothing, i:pi, t1
  debug 67 file 0 line 32 column 3 id -1 kind 21
    ADR_AT f:#t2, i:b, t3
    ADD_64 i:pd, f:#t2, c:#c4
  debug 75 file 0 line 33 column 3 id -1 kind 21
    LOAD_PTR i:wild, i:pd, t9
  debug 79 file 0 line 34 column 3 id -1 kind 21
    ADR_AT i:p, i:r, t4
  debug 83 file 0 line 35 column 3 id -1 kind 21
    LOAD_PTR f:#t1, i:p, t2
    CALL_STD s0, i:closed, f:#t1  ; "BYTE_TO_DWORD:BYTE,DWORD"
  debug 91 file 0 line 36 column 3 id -1 kind 21
    STORE_PTR i:p, c:#c5, t2
  debug 95 file 0 line 37 column 3 id -1 kind 21
    ADR_AT i:pr, i:r, t4
  debug 99 file 0 line 38 column 3 id -1 kind 21
    LOAD_PTR f:#t3, i:pr, t4
    LOAD_VIA i:exact, f:#t3, t1
  debug 107 file 0 line 39 column 3 id -1 kind 21
    LOAD_VIA i:kept, i:r, t1
  debug 111 file 0 line 40 column 3 id -1 kind 21
    ADR_AT i:pi, i:k, t1
  debug 115 file 0 line 41 column 3 id -1 kind 21
    LOAD_PTR i:fixed, i:pi, t1
  debug 119 file 0 line 42 column 3 id -1 kind 21
    STORE_PTR i:pi, c:#c6, t1
    RETURN
pou "Cyclic" task instance t16 frame t15
  instance main.a = 1
  instance main.b[0] = 1
  instance main.b[1] = 2
  instance main.b[2] = 3
  instance main.b[3] = 4
  instance main.c = 3
  instance main.nothing = 7
  instance main.k = 5
  debug 0 file 0 line 48 column 13 id -1 kind 19
    CALL_POU p0, i:main  ; "Test"
  debug 3 file 0 line 47 column 10 id -1 kind 18
    RETURN
task "Cyclic" period 10000000 priority 1 single "" body p1
