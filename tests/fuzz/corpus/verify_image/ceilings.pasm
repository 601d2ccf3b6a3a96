image 7
project "test"
product "PICARD test"
options drawing none separate priority-ceiling auto ""
type 0 scalar DINT
type 1 struct size 0 align 1 name "P0"
type 2 struct size 0 align 1 name "P0#frame"
type 3 struct size 0 align 1 name "P1"
type 4 struct size 0 align 1 name "P1#frame"
type 5 struct size 12 align 4 name "globals"
  field "g0" t0 at 0 member
  field "g1" t0 at 4 member
  field "both" t0 at 8 member
type 6 struct size 0 align 1 name "constants"
type 7 struct size 0 align 1 name "T0"
  field "P00" t1 at 0 local
type 8 struct size 0 align 1 name "T0#frame"
type 9 struct size 0 align 1 name "T1"
  field "P10" t3 at 0 local
type 10 struct size 0 align 1 name "T1#frame"
globals 5
  global 0 "" "" 1
  global 1 "" "" 1
  global 2 "" "" 2
constants 6
pou "P0" program instance t1 frame t2
    ADD_32 g:g0, g:g0, g:g1
    MOVE_32 g:both, g:g0
    RETURN
pou "P1" program instance t3 frame t4
    ADD_32 g:g1, g:g1, g:g0
    MOVE_32 g:both, g:g1
    RETURN
pou "T0" task instance t7 frame t8
    RAISE_PRIORITY 0, 3
    READ_N 0, 3
    RESCHEDULE
    CALL_POU p0, i:P00  ; "P0"
    RAISE_PRIORITY 0, 3
    WRITE_N 0, 1
    WRITE_CHANGED_N 2, 1
    RESCHEDULE
    RETURN
pou "T1" task instance t9 frame t10
    RAISE_PRIORITY 0, 3
    READ_N 0, 3
    RESCHEDULE
    CALL_POU p1, i:P10  ; "P1"
    RAISE_PRIORITY 0, 3
    WRITE_N 1, 1
    WRITE_CHANGED_N 2, 1
    RESCHEDULE
    RETURN
task "T0" period 1000000 priority 0 single "" body p2
task "T1" period 1000000 priority 1 single "" body p3
