image 7
project "project"
product "PICARD 0.1.0"
options drawing none separate wait-free auto ""
file "tests/cases/st/pointers-to-function-blocks/project.st"
type 0 struct size 0 align 1 name "#globals"
type 1 scalar INT
type 2 scalar POINTER
type 3 struct size 16 align 8 name "Counter"
  field "step" t1 at 0 input
  field "count" t1 at 2 output
  field "place" t2 at 8 output
type 4 struct size 0 align 1
type 5 array t3 3 from 0
type 6 struct size 24 align 8 name "Station"
  field "number" t1 at 0 member
  field "counter" t3 at 8 member
type 7 scalar POINTER
type 8 scalar POINTER
type 9 scalar BOOL
type 10 scalar TIME
type 11 scalar USINT
type 12 struct size 32 align 8 name "TON"
  field "IN" t9 at 0 input
  field "Q" t9 at 1 output
  field "M" t9 at 2 state
  field "STATE" t11 at 3 state
  field "PT" t10 at 8 input
  field "ET" t10 at 16 output
  field "START" t10 at 24 state
type 13 scalar POINTER
type 14 scalar POINTER
type 15 struct size 176 align 8 name "Test"
  field "one" t3 at 0 local
  field "many" t5 at 16 local
  field "station" t6 at 64 local
  field "p" t7 at 88 local
  field "ps" t8 at 96 local
  field "t" t12 at 104 local
  field "pt" t13 at 136 local
  field "i" t1 at 144 local
  field "inside" t1 at 146 local
  field "outside" t1 at 148 local
  field "elapsed" t10 at 152 local
  field "pv" t14 at 160 local
  field "wrong" t2 at 168 local
type 16 ref t3
type 17 ref t6
type 18 ref t12
type 19 struct size 48 align 8
  field "#t0" t16 at 0 hidden
  field "#t1" t9 at 8 hidden
  field "#t2" t17 at 16 hidden
  field "#t3" t17 at 24 hidden
  field "#t4" t1 at 32 hidden
  field "#t5" t18 at 40 hidden
type 20 struct size 0 align 1
type 21 struct size 176 align 8 name "Cyclic"
  field "main" t15 at 0 member
type 22 struct size 32 align 8 name "#constants"
  field "#c0" t1 at 0 member constant
  field "#c1" t1 at 2 member constant
  field "#c2" t1 at 4 member constant
  field "#c3" t1 at 6 member constant
  field "#c4" t1 at 8 member constant
  field "#c5" t9 at 10 member constant
  field "#c6" t10 at 16 member constant
  field "#c7" t1 at 24 member constant
  field "#c8" t1 at 26 member constant
globals 0
constants 22
  init #c0 = 5
  init #c1 = 2
  init #c3 = 1
  init #c4 = 3
  init #c5 = 1
  init #c6 = 1000000000
  init #c7 = 70
  init #c8 = 4
block "TON" 0xc04cc7e3df6a691c t12
pou "Counter" block instance t3 frame t4
  instance step = 1
  debug 0 file 0 line 8 column 3 id -1 kind 21
    ADD_16 i:count, i:count, i:step
  debug 4 file 0 line 9 column 3 id -1 kind 21
    ADR_AT i:place, i:count, t1
    RETURN
pou "Test" program instance t15 frame t19
  instance one.step = 1
  instance many[0].step = 1
  instance many[1].step = 1
  instance many[2].step = 1
  instance station.counter.step = 1
  debug 0 file 0 line 31 column 3 id -1 kind 21
    ADR_AT i:p, i:one, t3
  debug 4 file 0 line 32 column 3 id -1 kind 21
    REF_PTR f:#t0, i:p, t3
    STORE_VIA f:#t0, c:#c0, t3, .0
    CALL_VIA p0, f:#t0, t3  ; "Counter"
  debug 18 file 0 line 33 column 3 id -1 kind 21
    REF_PTR f:#t0, i:p, t3
    STORE_VIA f:#t0, c:#c1, t3, .0
  debug 28 file 0 line 34 column 3 id -1 kind 21
    REF_PTR f:#t0, i:p, t3
    CALL_VIA p0, f:#t0, t3  ; "Counter"
  debug 36 file 0 line 35 column 3 id -1 kind 21
    MOVE_16 i:i, c:#c2
  debug 39 file 0 line 36 column 5 id -1 kind 21
L39:
    ADR_AT i:p, i:many, t5, [i:i]
  debug 45 file 0 line 37 column 5 id -1 kind 21
    REF_PTR f:#t0, i:p, t3
    STORE_VIA f:#t0, i:i, t3, .0
    CALL_VIA p0, f:#t0, t3  ; "Counter"
  debug 59 file 0 line 35 column 3 id -1 kind 21
    LT_I16 f:#t1, i:i, c:#c1
    COND_JUMP f:#t1, L72
    ADD_16 i:i, i:i, c:#c3
    LOOP_JUMP L39
L72:
    ADD_16 i:i, i:i, c:#c3
  debug 76 file 0 line 39 column 3 id -1 kind 21
    ADR_AT i:ps, i:station, t6
  debug 80 file 0 line 40 column 3 id -1 kind 21
    REF_PTR f:#t2, i:ps, t6
    STORE_VIA f:#t2, c:#c4, t6, .0
  debug 90 file 0 line 41 column 3 id -1 kind 21
    REF_PTR f:#t2, i:ps, t6
    REF_PTR f:#t3, i:ps, t6
    LOAD_VIA f:#t4, f:#t3, t6, .0
    STORE_VIA f:#t2, f:#t4, t6, .1, .0
    CALL_VIA p0, f:#t2, t6, .1  ; "Counter"
  debug 118 file 0 line 42 column 3 id -1 kind 21
    REF_PTR f:#t2, i:ps, t6
    ADR_VIA i:p, f:#t2, t6, .1
  debug 128 file 0 line 43 column 3 id -1 kind 21
    REF_PTR f:#t0, i:p, t3
    LOAD_VIA i:inside, f:#t0, t3, .1
  debug 138 file 0 line 44 column 3 id -1 kind 21
    ADR_AT i:pt, i:t, t12
  debug 142 file 0 line 45 column 3 id -1 kind 21
    REF_PTR f:#t5, i:pt, t12
    STORE_VIA f:#t5, c:#c5, t12, .0
    STORE_VIA f:#t5, c:#c6, t12, .4
    RUN_VIA b0, f:#t5, t12  ; "TON"
  debug 162 file 0 line 46 column 3 id -1 kind 21
    ADR_AT i:pv, i:t.ET, t10
  debug 166 file 0 line 47 column 3 id -1 kind 21
    LOAD_PTR i:elapsed, i:pv, t10
  debug 170 file 0 line 48 column 3 id -1 kind 21
    STORE_PTR i:one.place, c:#c7, t1
  debug 174 file 0 line 49 column 3 id -1 kind 21
    MOVE_16 i:outside, i:one.count
  debug 177 file 0 line 50 column 3 id -1 kind 21
    ADR_AT i:wrong, i:i, t1
  debug 181 file 0 line 51 column 3 id -1 kind 21
    MOVE_64 i:p, i:wrong
  debug 184 file 0 line 52 column 3 id -1 kind 21
    REF_PTR f:#t0, i:p, t3
    STORE_VIA f:#t0, c:#c8, t3, .0
    RETURN
pou "Cyclic" task instance t21 frame t20
  instance main.one.step = 1
  instance main.many[0].step = 1
  instance main.many[1].step = 1
  instance main.many[2].step = 1
  instance main.station.counter.step = 1
  debug 0 file 0 line 58 column 13 id -1 kind 19
    CALL_POU p1, i:main  ; "Test"
  debug 3 file 0 line 57 column 10 id -1 kind 18
    RETURN
task "Cyclic" period 10000000 priority 1 single "" body p2
