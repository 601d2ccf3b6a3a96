image 7
project "project"
product "PICARD 0.1.0"
options drawing none separate wait-free auto ""
file "tests/cases/st/pointers-in-32-bits/project.st"
type 0 struct size 0 align 1 name "#globals"
type 1 struct size 0 align 1
type 2 scalar BOOL
type 3 scalar POINTER
type 4 scalar UINT
type 5 scalar POINTER
type 6 scalar DWORD
type 7 scalar UDINT
type 8 scalar BYTE
type 9 scalar LINT
type 10 struct size 64 align 8
  field "Clear" t2 at 0 return
  field "pt" t3 at 8 input
  field "size" t4 at 16 input
  field "ptw" t5 at 24 local
  field "temp" t6 at 32 local
  field "end" t6 at 36 local
  field "end32" t6 at 40 local
  field "#t0" t6 at 44 hidden
  field "#t1" t7 at 48 hidden
  field "#t2" t7 at 52 hidden
  field "#t3" t7 at 56 hidden
  field "#t4" t2 at 60 hidden
  field "#t5" t2 at 61 hidden
  field "#t6" t2 at 62 hidden
type 11 array t8 11 from 0
type 12 scalar LWORD
type 13 scalar ULINT
type 14 scalar INT
type 15 scalar POINTER
type 16 struct size 80 align 8 name "Test"
  field "a" t11 at 0 local
  field "done" t2 at 11 local
  field "p" t3 at 16 local
  field "address" t6 at 24 local
  field "wide" t12 at 32 local
  field "whole" t13 at 40 local
  field "aligned" t2 at 48 local
  field "same" t2 at 49 local
  field "again" t2 at 50 local
  field "n" t7 at 52 local
  field "lost" t7 at 56 local
  field "x" t14 at 60 local
  field "px" t15 at 64 local
  field "read" t14 at 72 local
type 17 scalar POINTER
type 18 struct size 40 align 8
  field "#t0" t3 at 0 hidden
  field "#t1" t6 at 8 hidden
  field "#t2" t7 at 12 hidden
  field "#t3" t7 at 16 hidden
  field "#t4" t13 at 24 hidden
  field "#t5" t17 at 32 hidden
type 19 struct size 80 align 8 name "Cyclic"
  field "main" t16 at 0 member
type 20 struct size 80 align 8 name "#constants"
  field "#c0" t7 at 0 member constant
  field "#c1" t8 at 4 member constant
  field "#c2" t9 at 8 member constant
  field "#c3" t7 at 16 member constant
  field "#c4" t6 at 20 member constant
  field "#c5" t6 at 24 member constant
  field "#c6" t9 at 32 member constant
  field "#c7" t4 at 40 member constant
  field "#c8" t6 at 44 member constant
  field "#c9" t7 at 48 member constant
  field "#c10" t13 at 56 member constant
  field "#c11" t3 at 64 member constant
  field "#c12" t9 at 72 member constant
globals 0
constants 20
  init #c0 = 3
  init #c2 = 1
  init #c3 = 1
  init #c4 = 3
  init #c6 = 4
  init #c7 = 9
  init #c8 = 7
  init #c9 = 2
  init #c12 = 1000
function "UINT_TO_DWORD:UINT,DWORD"
function "DWORD_TO_UDINT:DWORD,UDINT"
function "UDINT_TO_DWORD:UDINT,DWORD"
pou "Clear" function instance t1 frame t10
  debug 0 file 0 line 9 column 3 id -1 kind 21
    PTR_TO_32 f:temp, f:pt
  debug 3 file 0 line 10 column 3 id -1 kind 21
    CALL_STD s0, f:#t0, f:size  ; "UINT_TO_DWORD:UINT,DWORD"
    CALL_STD s1, f:#t1, f:temp  ; "DWORD_TO_UDINT:DWORD,UDINT"
    CALL_STD s1, f:#t2, f:#t0  ; "DWORD_TO_UDINT:DWORD,UDINT"
    ADD_32 f:#t3, f:#t1, f:#t2
    CALL_STD s2, f:end, f:#t3  ; "UDINT_TO_DWORD:UDINT,DWORD"
  debug 23 file 0 line 11 column 3 id -1 kind 21
    CALL_STD s1, f:#t3, f:end  ; "DWORD_TO_UDINT:DWORD,UDINT"
    SUB_32 f:#t2, f:#t3, c:#c0
    CALL_STD s2, f:end32, f:#t2  ; "UDINT_TO_DWORD:UDINT,DWORD"
  debug 35 file 0 line 12 column 3 id -1 kind 21
    JUMP L57
  debug 37 file 0 line 13 column 5 id -1 kind 21
L37:
    STORE_PTR f:pt, c:#c1, t8
  debug 41 file 0 line 14 column 5 id -1 kind 21
    ADD_64 f:pt, f:pt, c:#c2
  debug 45 file 0 line 15 column 5 id -1 kind 21
    CALL_STD s1, f:#t2, f:temp  ; "DWORD_TO_UDINT:DWORD,UDINT"
    ADD_32 f:#t3, f:#t2, c:#c3
    CALL_STD s2, f:temp, f:#t3  ; "UDINT_TO_DWORD:UDINT,DWORD"
  debug 57 file 0 line 12 column 3 id -1 kind 21
L57:
    PTR_TO_32 f:#t3, f:pt
    LT_U32 f:#t4, f:#t3, f:end
    AND_32 f:#t0, f:temp, c:#c4
    GT_U32 f:#t5, f:#t0, c:#c5
    BOOL_RUN
      | 0x88888888 f:#t6, f:#t4, f:#t5, f:#t4, f:#t4, f:#t4
    COND_JUMP f:#t6, L85
    LOOP_JUMP L37
  debug 85 file 0 line 17 column 3 id -1 kind 21
L85:
    MOVE_64 f:ptw, f:pt
  debug 88 file 0 line 18 column 3 id -1 kind 21
    JUMP L98
  debug 90 file 0 line 19 column 5 id -1 kind 21
L90:
    STORE_PTR f:ptw, c:#c5, t6
  debug 94 file 0 line 20 column 5 id -1 kind 21
    ADD_64 f:ptw, f:ptw, c:#c6
  debug 98 file 0 line 18 column 3 id -1 kind 21
L98:
    PTR_TO_32 f:#t3, f:ptw
    LT_U32 f:#t6, f:#t3, f:end32
    COND_JUMP f:#t6, L110
    LOOP_JUMP L90
  debug 110 file 0 line 22 column 3 id -1 kind 21
L110:
    MOVE_64 f:pt, f:ptw
  debug 113 file 0 line 23 column 3 id -1 kind 21
    JUMP L123
  debug 115 file 0 line 24 column 5 id -1 kind 21
L115:
    STORE_PTR f:pt, c:#c1, t8
  debug 119 file 0 line 25 column 5 id -1 kind 21
    ADD_64 f:pt, f:pt, c:#c2
  debug 123 file 0 line 23 column 3 id -1 kind 21
L123:
    PTR_TO_32 f:#t3, f:pt
    LT_U32 f:#t6, f:#t3, f:end
    COND_JUMP f:#t6, L135
    LOOP_JUMP L115
  debug 135 file 0 line 27 column 3 id -1 kind 21
L135:
    BOOL_RUN
      | 0xffffffff f:Clear, f:Clear, f:Clear, f:Clear, f:Clear, f:Clear
    RETURN
pou "Test" program instance t16 frame t18
  instance a[0] = 255
  instance a[1] = 255
  instance a[2] = 255
  instance a[3] = 255
  instance a[4] = 255
  instance a[5] = 255
  instance a[6] = 255
  instance a[7] = 255
  instance a[8] = 255
  instance a[9] = 255
  instance a[10] = 255
  instance x = 5
  debug 0 file 0 line 45 column 3 id -1 kind 21
    ADR_AT f:#t0, i:a[1], t8
    CALL_FN p0, 1=f:#t0, 2=c:#c7, 0=i:done  ; "Clear"
  debug 12 file 0 line 46 column 3 id -1 kind 21
    ADR_AT i:p, i:a, t11
  debug 16 file 0 line 47 column 3 id -1 kind 21
    PTR_TO_32 i:address, i:p
  debug 19 file 0 line 48 column 3 id -1 kind 21
    AND_32 f:#t1, i:address, c:#c8
    EQ_32 i:aligned, f:#t1, c:#c5
  debug 27 file 0 line 49 column 3 id -1 kind 21
    CALL_STD s1, f:#t2, i:address  ; "DWORD_TO_UDINT:DWORD,UDINT"
    ADD_32 f:#t3, f:#t2, c:#c9
    CALL_STD s2, i:address, f:#t3  ; "UDINT_TO_DWORD:UDINT,DWORD"
  debug 39 file 0 line 50 column 3 id -1 kind 21
    PTR_FROM_32 i:p, i:address
  debug 42 file 0 line 51 column 3 id -1 kind 21
    ADR_AT f:#t0, i:a[2], t8
    EQ_64 i:same, i:p, f:#t0
  debug 50 file 0 line 52 column 3 id -1 kind 21
    ADD_64 i:wide, i:p, c:#c10
  debug 54 file 0 line 53 column 3 id -1 kind 21
    MOVE_64 i:p, c:#c11
  debug 57 file 0 line 54 column 3 id -1 kind 21
    ADD_64 i:p, i:wide, c:#c10
  debug 61 file 0 line 55 column 3 id -1 kind 21
    ADR_AT f:#t0, i:a[2], t8
    EQ_64 i:again, i:p, f:#t0
  debug 69 file 0 line 56 column 3 id -1 kind 21
    ADR_AT i:px, i:x, t14
  debug 73 file 0 line 57 column 3 id -1 kind 21
    ADD_64 i:whole, i:px, c:#c10
  debug 77 file 0 line 58 column 3 id -1 kind 21
    ADD_64 f:#t4, i:whole, c:#c10
    ADD_64 i:px, f:#t4, c:#c10
  debug 85 file 0 line 59 column 3 id -1 kind 21
    LOAD_PTR i:read, i:px, t14
  debug 89 file 0 line 60 column 3 id -1 kind 21
    ADR_AT f:#t5, i:a, t11
    ADD_64 i:p, f:#t5, c:#c12
  debug 97 file 0 line 61 column 3 id -1 kind 21
    PTR_TO_32 i:lost, i:p
    RETURN
pou "Cyclic" task instance t19 frame t1
  instance main.a[0] = 255
  instance main.a[1] = 255
  instance main.a[2] = 255
  instance main.a[3] = 255
  instance main.a[4] = 255
  instance main.a[5] = 255
  instance main.a[6] = 255
  instance main.a[7] = 255
  instance main.a[8] = 255
  instance main.a[9] = 255
  instance main.a[10] = 255
  instance main.x = 5
  debug 0 file 0 line 67 column 13 id -1 kind 19
    CALL_POU p1, i:main  ; "Test"
  debug 3 file 0 line 66 column 10 id -1 kind 18
    RETURN
task "Cyclic" period 10000000 priority 1 single "" body p2
