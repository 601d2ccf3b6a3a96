image 7
project "project"
product "PICARD 0.1.0"
options drawing none separate wait-free auto ""
file "tests/cases/st/pointers-to-the-bytes-of-texts/project.st"
type 0 struct size 0 align 1 name "#globals"
type 1 struct size 0 align 1
type 2 string STRING 20 align 2
type 3 scalar POINTER
type 4 scalar BYTE
type 5 scalar BOOL
type 6 scalar LINT
type 7 struct size 80 align 8
  field "Upper" t2 at 0 return
  field "s" t2 at 24 input
  field "p" t3 at 48 local
  field "#t0" t4 at 56 hidden
  field "#t1" t5 at 57 hidden
  field "#t2" t5 at 58 hidden
  field "#t3" t5 at 59 hidden
  field "#t4" t6 at 64 hidden
  field "#t5" t6 at 72 hidden
type 8 string STRING 4 align 2
type 9 scalar WORD
type 10 scalar INT
type 11 scalar POINTER
type 12 scalar DINT
type 13 struct size 72 align 8
  field "Hex" t8 at 0 return
  field "value" t9 at 8 input
  field "p" t3 at 16 local
  field "i" t10 at 24 local
  field "digit" t4 at 26 local
  field "#t0" t11 at 32 hidden
  field "#t1" t9 at 40 hidden
  field "#t2" t5 at 42 hidden
  field "#t3" t6 at 48 hidden
  field "#t4" t6 at 56 hidden
  field "#t5" t4 at 64 hidden
type 14 string STRING 10 align 2
type 15 array t4 10 from 0
type 16 scalar POINTER
type 17 string WSTRING 4 align 2
type 18 scalar POINTER
type 19 struct size 176 align 8 name "Test"
  field "upper" t2 at 0 local
  field "hex" t8 at 24 local
  field "s" t14 at 32 local
  field "p" t3 at 48 local
  field "cut" t14 at 56 local
  field "grown" t14 at 70 local
  field "full" t14 at 84 local
  field "length" t10 at 98 local
  field "last" t10 at 100 local
  field "zero" t4 at 102 local
  field "five" t4 at 103 local
  field "buffer" t15 at 104 local
  field "ps" t16 at 120 local
  field "text" t14 at 128 local
  field "w" t17 at 142 local
  field "pw" t18 at 160 local
  field "unit" t9 at 168 local
  field "i" t10 at 170 local
type 20 string STRING 3 align 2
type 21 struct size 40 align 8
  field "#t0" t3 at 0 hidden
  field "#t1" t6 at 8 hidden
  field "#t2" t6 at 16 hidden
  field "#t3" t5 at 24 hidden
  field "#t4" t4 at 25 hidden
  field "#t5" t18 at 32 hidden
type 22 struct size 176 align 8 name "Cyclic"
  field "main" t19 at 0 member
type 23 struct size 144 align 8 name "#constants"
  field "#c0" t4 at 0 member constant
  field "#c1" t4 at 1 member constant
  field "#c2" t6 at 8 member constant
  field "#c3" t6 at 16 member constant
  field "#c4" t4 at 24 member constant
  field "#c5" t6 at 32 member constant
  field "#c6" t10 at 40 member constant
  field "#c7" t9 at 42 member constant
  field "#c8" t4 at 44 member constant
  field "#c9" t6 at 48 member constant
  field "#c10" t6 at 56 member constant
  field "#c11" t12 at 64 member constant
  field "#c12" t10 at 68 member constant
  field "#c13" t8 at 70 member constant
  field "#c14" t9 at 78 member constant
  field "#c15" t6 at 80 member constant
  field "#c16" t6 at 88 member constant
  field "#c17" t6 at 96 member constant
  field "#c18" t4 at 104 member constant
  field "#c19" t10 at 106 member constant
  field "#c20" t4 at 108 member constant
  field "#c21" t10 at 110 member constant
  field "#c22" t6 at 112 member constant
  field "#c23" t20 at 120 member constant
  field "#c24" t6 at 128 member constant
  field "#c25" t9 at 136 member constant
globals 0
constants 23
  init #c0 = 97
  init #c1 = 122
  init #c2 = 32
  init #c3 = 1
  init #c5 = 4
  init #c6 = 1
  init #c7 = 15
  init #c8 = 9
  init #c9 = 48
  init #c10 = 55
  init #c11 = 4
  init #c12 = 4
  init #c13 = "Ab-c"
  init #c14 = 12042
  init #c15 = 6
  init #c16 = 5
  init #c17 = 3
  init #c18 = 68
  init #c20 = 120
  init #c21 = 10
  init #c22 = 10
  init #c23 = "Yes"
  init #c24 = 2
  init #c25 = 8364
function "BYTE_TO_LINT:BYTE,LINT"
function "LINT_TO_BYTE:LINT,BYTE"
function "WORD_TO_BYTE:WORD,BYTE"
function "SHR:WORD,DINT"
function "LEN:STRING"
function "INT_TO_LINT:INT,LINT"
function "BYTE_TO_INT:BYTE,INT"
pou "Upper" function instance t1 frame t7
  debug 0 file 0 line 9 column 3 id -1 kind 21
    ADR_AT f:p, f:s, t2
  debug 4 file 0 line 10 column 3 id -1 kind 21
    JUMP L57
  debug 6 file 0 line 11 column 5 id -1 kind 21
L6:
    LOAD_PTR f:#t0, f:p, t4
    GE_U8 f:#t1, f:#t0, c:#c0
    LOAD_PTR f:#t0, f:p, t4
    LE_U8 f:#t2, f:#t0, c:#c1
    BOOL_RUN
      | 0x88888888 f:#t3, f:#t1, f:#t2, f:#t1, f:#t1, f:#t1
    COND_JUMP f:#t3, L53
  debug 33 file 0 line 11 column 36 id -1 kind 21
    LOAD_PTR f:#t0, f:p, t4
    CALL_STD s0, f:#t4, f:#t0  ; "BYTE_TO_LINT:BYTE,LINT"
    SUB_64 f:#t5, f:#t4, c:#c2
    CALL_STD s1, f:#t0, f:#t5  ; "LINT_TO_BYTE:LINT,BYTE"
    STORE_PTR f:p, f:#t0, t4
  debug 53 file 0 line 12 column 5 id -1 kind 21
L53:
    ADD_64 f:p, f:p, c:#c3
  debug 57 file 0 line 10 column 3 id -1 kind 21
L57:
    LOAD_PTR f:#t0, f:p, t4
    NE_8 f:#t3, f:#t0, c:#c4
    COND_JUMP f:#t3, L70
    LOOP_JUMP L6
  debug 70 file 0 line 14 column 3 id -1 kind 21
L70:
    MOVE_STR f:Upper, f:s
    RETURN
pou "Hex" function instance t1 frame t13
  debug 0 file 0 line 20 column 3 id -1 kind 21
    ADR_AT f:#t0, f:Hex, t8
    ADD_64 f:p, f:#t0, c:#c5
  debug 8 file 0 line 21 column 3 id -1 kind 21
    STORE_PTR f:p, c:#c4, t4
  debug 12 file 0 line 22 column 3 id -1 kind 21
    MOVE_16 f:i, c:#c6
  debug 15 file 0 line 23 column 5 id -1 kind 21
L15:
    SUB_64 f:p, f:p, c:#c3
  debug 19 file 0 line 24 column 5 id -1 kind 21
    AND_16 f:#t1, f:value, c:#c7
    CALL_STD s2, f:digit, f:#t1  ; "WORD_TO_BYTE:WORD,BYTE"
  debug 27 file 0 line 25 column 5 id -1 kind 21
    LE_U8 f:#t2, f:digit, c:#c8
    COND_JUMP f:#t2, L52
  debug 34 file 0 line 25 column 24 id -1 kind 21
    CALL_STD s0, f:#t3, f:digit  ; "BYTE_TO_LINT:BYTE,LINT"
    ADD_64 f:#t4, f:#t3, c:#c9
    CALL_STD s1, f:#t5, f:#t4  ; "LINT_TO_BYTE:LINT,BYTE"
    STORE_PTR f:p, f:#t5, t4
    JUMP L68
  debug 52 file 0 line 25 column 47 id -1 kind 21
L52:
    CALL_STD s0, f:#t4, f:digit  ; "BYTE_TO_LINT:BYTE,LINT"
    ADD_64 f:#t3, f:#t4, c:#c10
    CALL_STD s1, f:#t5, f:#t3  ; "LINT_TO_BYTE:LINT,BYTE"
    STORE_PTR f:p, f:#t5, t4
  debug 68 file 0 line 26 column 5 id -1 kind 21
L68:
    CALL_STD s3, f:value, f:value, c:#c11  ; "SHR:WORD,DINT"
  debug 73 file 0 line 22 column 3 id -1 kind 21
    LT_I16 f:#t2, f:i, c:#c12
    COND_JUMP f:#t2, L86
    ADD_16 f:i, f:i, c:#c6
    LOOP_JUMP L15
L86:
    ADD_16 f:i, f:i, c:#c6
    RETURN
pou "Test" program instance t19 frame t21
  instance s = "abcdef"
  instance buffer[0] = 72
  instance buffer[1] = 105
  instance buffer[3] = 7
  instance buffer[4] = 7
  instance w = w"00780079"
  debug 0 file 0 line 47 column 3 id -1 kind 21
    CALL_FN p0, 1=c:#c13, 0=i:upper  ; "Upper"
  debug 6 file 0 line 48 column 3 id -1 kind 21
    CALL_FN p1, 1=c:#c14, 0=i:hex  ; "Hex"
  debug 12 file 0 line 49 column 3 id -1 kind 21
    ADR_AT i:p, i:s, t14
  debug 16 file 0 line 50 column 3 id -1 kind 21
    ADD_64 f:#t0, i:p, c:#c15
    LOAD_PTR i:zero, f:#t0, t4
  debug 24 file 0 line 51 column 3 id -1 kind 21
    ADD_64 f:#t0, i:p, c:#c16
    LOAD_PTR i:five, f:#t0, t4
  debug 32 file 0 line 52 column 3 id -1 kind 21
    ADD_64 f:#t0, i:p, c:#c17
    STORE_PTR f:#t0, c:#c4, t4
  debug 40 file 0 line 53 column 3 id -1 kind 21
    MOVE_STR i:cut, i:s
  debug 43 file 0 line 54 column 3 id -1 kind 21
    CALL_STD s4, i:length, i:s  ; "LEN:STRING"
  debug 47 file 0 line 55 column 3 id -1 kind 21
    ADD_64 f:#t0, i:p, c:#c17
    STORE_PTR f:#t0, c:#c18, t4
  debug 55 file 0 line 56 column 3 id -1 kind 21
    MOVE_STR i:grown, i:s
  debug 58 file 0 line 57 column 3 id -1 kind 21
    MOVE_16 i:i, c:#c19
  debug 61 file 0 line 58 column 5 id -1 kind 21
L61:
    CALL_STD s5, f:#t1, i:i  ; "INT_TO_LINT:INT,LINT"
    MUL_64 f:#t2, f:#t1, c:#c3
    ADD_64 f:#t0, i:p, f:#t2
    STORE_PTR f:#t0, c:#c20, t4
  debug 77 file 0 line 57 column 3 id -1 kind 21
    LT_I16 f:#t3, i:i, c:#c21
    COND_JUMP f:#t3, L90
    ADD_16 i:i, i:i, c:#c6
    LOOP_JUMP L61
L90:
    ADD_16 i:i, i:i, c:#c6
  debug 94 file 0 line 60 column 3 id -1 kind 21
    MOVE_STR i:full, i:s
  debug 97 file 0 line 61 column 3 id -1 kind 21
    ADD_64 f:#t0, i:p, c:#c22
    LOAD_PTR f:#t4, f:#t0, t4
    CALL_STD s6, i:last, f:#t4  ; "BYTE_TO_INT:BYTE,INT"
  debug 109 file 0 line 62 column 3 id -1 kind 21
    ADR_AT i:ps, i:buffer, t15
  debug 113 file 0 line 63 column 3 id -1 kind 21
    LOAD_PTR i:text, i:ps, t14
  debug 117 file 0 line 64 column 3 id -1 kind 21
    STORE_PTR i:ps, c:#c23, t14
  debug 121 file 0 line 65 column 3 id -1 kind 21
    ADR_AT i:pw, i:w, t17
  debug 125 file 0 line 66 column 3 id -1 kind 21
    ADD_64 f:#t5, i:pw, c:#c24
    LOAD_PTR i:unit, f:#t5, t9
  debug 133 file 0 line 67 column 3 id -1 kind 21
    ADD_64 f:#t5, i:pw, c:#c24
    STORE_PTR f:#t5, c:#c25, t9
    RETURN
pou "Cyclic" task instance t22 frame t1
  instance main.s = "abcdef"
  instance main.buffer[0] = 72
  instance main.buffer[1] = 105
  instance main.buffer[3] = 7
  instance main.buffer[4] = 7
  instance main.w = w"00780079"
  debug 0 file 0 line 73 column 13 id -1 kind 19
    CALL_POU p2, i:main  ; "Test"
  debug 3 file 0 line 72 column 10 id -1 kind 18
    RETURN
task "Cyclic" period 10000000 priority 1 single "" body p3
