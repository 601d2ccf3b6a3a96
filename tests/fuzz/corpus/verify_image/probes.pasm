image 7
project "test"
product "PICARD test"
probes 0 040000000000000000000000000000000000000000000000000000000d000000
probes 32 010000000d000000100002011000000005000201000100020804022600021000
probes 64 0c0811000300050700030002100400040c06b4020e0001990101161a05000200
probes 96 0200050002020200050002020200050002020200050002020200050002020200
probes 128 0500020202000500020202000500020202000500020202000500020202000500
probes 160 0202020005000202000000000000000000000000
options drawing none separate wait-free auto ""
file "sample.xml"
type 0 scalar BOOL
type 1 scalar INT
type 2 scalar DINT
type 3 scalar LINT
type 4 scalar REAL
type 5 scalar INT limits 1 3 member "Red" 1 member "Green" 2 member "Blue" 3 name "Colour"
type 6 array t2 4 from 1
type 7 struct size 8 align 4 name "Point"
  field "x" t2 at 0 member
  field "y" t2 at 4 member
type 8 string STRING 20 align 2
type 9 string WSTRING 6 align 2
type 10 ref t2
type 11 scalar LREAL
type 12 string STRING 13 align 2
type 13 struct size 0 align 1 name "Max2"
type 14 struct size 64 align 8 name "Max2#frame"
  field "a" t2 at 0 input
  field "c" t2 at 4 input
  field "Max2" t2 at 8 return
  field "at" t10 at 16 inout
  field "where" t7 at 24 input
  field "text" t8 at 32 input
  field "t#0" t0 at 56 hidden
type 15 scalar TIME
type 16 scalar USINT
type 17 struct size 32 align 8 name "TON"
  field "IN" t0 at 0 input
  field "Q" t0 at 1 output
  field "M" t0 at 2 state
  field "STATE" t16 at 3 state
  field "PT" t15 at 8 input
  field "ET" t15 at 16 output
  field "START" t15 at 24 state
type 18 struct size 40 align 8 name "Motor"
  field "run" t0 at 0 input
  field "speed" t1 at 2 output
  field "ton" t17 at 8 local
  alias "sensor" global 3
type 19 struct size 0 align 1 name "Motor#frame"
type 20 array t18 2 from 1
type 21 array t7 3 from -1
type 22 ref t7
type 23 ref t6
type 24 ref t18
type 25 ref t17
type 26 scalar UDINT
type 27 struct size 208 align 8 name "Main"
  field "motor" t18 at 0 local
  field "motors" t20 at 40 local
  field "grid" t21 at 120 local
  field "line" t6 at 144 local
  field "backup" t6 at 160 local
  field "point" t7 at 176 local
  field "r_point" t22 at 184 local
  field "r_line" t23 at 192 local
  field "r_motor" t24 at 200 local
type 28 struct size 24 align 8 name "Main#frame"
  field "r#0" t10 at 0 temp
  field "r#1" t25 at 8 temp
  field "ok" t0 at 16 temp
  field "i" t1 at 18 temp
  field "count" t26 at 20 temp
type 29 struct size 72 align 8 name "globals"
  field "go" t0 at 0 member
  field "level" t1 at 2 member
  field "limit" t1 at 4 member constant
  field "sensor" t0 at 6 member
  field "total" t2 at 8 member
  field "title" t8 at 12 member
  field "wide" t9 at 36 member
  field "colour" t5 at 52 member
  field "gain" t4 at 56 member
  field "sum" t11 at 64 member
type 30 struct size 20 align 2 name "constants"
  field "c#0" t1 at 0 hidden constant
  field "c#1" t12 at 2 hidden constant
type 31 struct size 208 align 8 name "Fast"
  field "Main0" t27 at 0 local
type 32 struct size 0 align 1 name "Fast#frame"
globals 29
  global 0 "" "" 1
  global 1 "" "" 1
  global 3 "IO" "%IX0.0" 0
  global 4 "" "" 1
  global 5 "" "" 1
  global 6 "" "" 1
  global 7 "" "" 1
  global 8 "" "" 1
  global 9 "" "" 1
  init level = -7
  init limit = 100
  init colour = 1
  init gain = nan
  init sum = 0.1
constants 30
  init c#0 = 1
  init c#1 = "say \22hi\22; \5c \0a"
block "TON" 0xc04cc7e3df6a691c t17
function "ADD:INT"
queue "orders" t2 capacity 4 takes 0 puts 0
pou "Max2" function instance t13 frame t14
    MOVE_32 f:Max2, f:a
    LT_I32 f:t#0, f:a, f:c
    COND_JUMP f:t#0, L13
    MOVE_32 f:Max2, f:c
L13:
    STORE_VIA f:at, f:Max2, t2
    RETURN
pou "Motor" block instance t18 frame t19
    BOOL_RUN
      | 0x00000002 i:ton.IN, i:run, g:go, i:run, i:run, i:run
    RUNTB b0, i:ton  ; "TON"
    ADD_16 i:speed, i:speed, c:c#0
    RETURN
pou "Main" program instance t27 frame t28
  debug 0 file 0 line 12 column 3 id 10000000001 kind 3
    ADD_16 g:level, g:level, c:c#0
  debug 4 file 0 line 13 column 5 id 4 kind 1
    MOVE_STR g:title, c:c#1
    CALL_POU p1, i:motor  ; "Motor"
    COPY i:backup, i:line, t6
    REF_AT i:r_line, i:line, t6
    REF_VIA f:r#0, i:r_line, t6, [f:i]
    LOAD_VIA g:total, i:r_line, t6, [3]
    REF_AT i:r_point, i:point, t7
    REF_VIA f:r#0, i:r_point, t7, .1
    MOVE_REF f:r#0, f:r#0
    SAME_REF f:ok, f:r#0, i:r_point
    REF_AT i:r_motor, i:motor, t18
    CALL_VIA p1, i:r_motor, t18  ; "Motor"
    REF_AT f:r#1, i:motor, t18, .2
    RUN_VIA b0, f:r#1, t17  ; "TON"
    LOAD_AT g:total, i:grid, t21, [g:level], .1
    STORE_AT i:grid, g:total, t21, [1], .0
    CALL_AT p1, i:motors, t20, [f:i]  ; "Motor"
    RUN_AT b0, i:motors, t20, [f:i], .2  ; "TON"
    CALL_FN p0, 0=g:total, 1=g:total, 2=g:total, 3=f:r#0, 4=i:point.x  ; "Max2"
    QUEUE_PUT f:ok, q0, g:total, t2  ; "orders"
    QUEUE_GET f:ok, q0, g:total, t2  ; "orders"
    QUEUE_COUNT f:count, q0  ; "orders"
    QUEUE_SPACE f:count, q0  ; "orders"
    CLEAR_EVENT
    CALL_STD s0, f:i, g:level, c:c#0  ; "ADD:INT"
    ENO f:ok
    EXTRACT f:ok, g:level, 3
    INSERT g:level, g:level, f:ok, 15
    RANGE_I16 f:i, g:level, c:c#0, g:limit
L145:
    ADD_16 f:i, f:i, c:c#0
    LT_I16 f:ok, f:i, g:limit
    COND_JUMP f:ok, L158
    LOOP_JUMP L145
L158:
    RETURN
pou "Fast" task instance t31 frame t32
    READ_N 0, 10
    CALL_POU p2, i:Main0  ; "Main"
    WRITE_N 0, 2
    WRITE_N 4, 6
    RETURN
task "Fast" period 10000000 priority 0 single "" body p3
