image 7
project "case"
product "PICARD 0.1.0"
options drawing none separate wait-free on ""
file "tests/cases/sfc/entry-main-and-exit-actions/project.xml"
type 0 struct size 0 align 1 name "#globals"
type 1 scalar BOOL
type 2 scalar INT
type 3 scalar TIME
type 4 struct size 16 align 8 name "#STEP"
  field "X" t1 at 0 member
  field "T" t3 at 8 member
type 5 struct size 8 align 8 name "UPTIME"
  field "OUT" t3 at 0 output
type 6 struct size 120 align 8 name "Logic"
  field "go" t1 at 0 local
  field "ins" t2 at 2 local
  field "m" t2 at 4 local
  field "x" t2 at 6 local
  field "seen" t2 at 8 local
  field "I" t4 at 16 local internal
  field "X1" t4 at 32 local internal
  field "E" t4 at 48 local internal
  field "#since.6" t3 at 64 hidden internal
  field "#on.7" t1 at 72 hidden internal
  field "#off.8" t1 at 73 hidden internal
  field "#since.10" t3 at 80 hidden internal
  field "#on.11" t1 at 88 hidden internal
  field "#off.12" t1 at 89 hidden internal
  field "#since.14" t3 at 96 hidden internal
  field "#on.15" t1 at 104 hidden internal
  field "#off.16" t1 at 105 hidden internal
  field "#entered.17" t1 at 106 hidden internal
  field "#left.18" t1 at 107 hidden internal
  field "#entered.19" t1 at 108 hidden internal
  field "#started.20" t1 at 109 hidden internal
  field "#moved.21" t1 at 110 hidden internal
  field "#now.22" t5 at 112 hidden internal
type 7 struct size 0 align 1
type 8 struct size 0 align 1
type 9 struct size 0 align 1
type 10 struct size 0 align 1
type 11 struct size 1 align 1
  field "#t0" t1 at 0 hidden
type 12 struct size 0 align 1
type 13 struct size 120 align 8 name "cyclic"
  field "main" t6 at 0 member
type 14 struct size 2 align 2 name "#constants"
  field "#c0" t2 at 0 member constant
globals 0
constants 14
  init #c0 = 1
block "UPTIME" 0xc8ec5615608f5811 t5
pou "Logic.Leave" block instance t6 frame t7
  debug 0 file 0 line 28 column 94 id -1 kind 21
    ADD_16 i:x, i:x, c:#c0
    RETURN
pou "Logic.Enter" block instance t6 frame t8
  debug 0 file 0 line 26 column 94 id -1 kind 21
    ADD_16 i:ins, i:ins, c:#c0
    RETURN
pou "Logic.Look" block instance t6 frame t9
  debug 0 file 0 line 29 column 93 id -1 kind 21
    MOVE_16 i:seen, i:x
    RETURN
pou "Logic.Main1" block instance t6 frame t10
  debug 0 file 0 line 27 column 94 id -1 kind 21
    ADD_16 i:m, i:m, c:#c0
    RETURN
pou "Logic" program instance t6 frame t11
  debug 0 file 0 line 31 column 9 id -1 kind 0
    RUNTB b0, i+112  ; "UPTIME"
    JUMP_IF i+109, L28
    BOOL_RUN
      | 0xffffffff i+109, i+109, i+109, i+109, i+109, i+109
      | 0xffffffff i+72, i+72, i+72, i+72, i+72, i+72
      | 0xffffffff i+110, i+110, i+110, i+110, i+110, i+110
L28:
    COND_JUMP i+110, L215
    BOOL_RUN
      | 0x00000000 i+110, i+110, i+110, i+110, i+110, i+110
      | 0xeeeeeeee f:#t0, i+72, i+73, i+72, i+72, i+72
  debug 39 file 0 line 33 column 13 id 1 kind 15
    COND_JUMP f:#t0, L78
    BOOL_RUN
      | 0xf2f2f2f2 i:I.X, i:I.X, i+73, i+72, i:I.X, i:I.X
    COND_JUMP i+72, L63
    MOVE_64 i+64, i+112
L63:
    BOOL_RUN
      | 0x00000000 i+72, i+72, i+72, i+72, i+72, i+72
      | 0x00000000 i+73, i+73, i+73, i+73, i+73, i+73
  debug 78 file 0 line 36 column 13 id 3 kind 15
L78:
    BOOL_RUN
      | 0xeeeeeeee f:#t0, i+88, i+89, i+88, i+88, i+88
    COND_JUMP f:#t0, L156
    BOOL_RUN
      | 0x08080808 f:#t0, i:X1.X, i+89, i+88, i:X1.X, i:X1.X
    COND_JUMP f:#t0, L108
    BOOL_RUN
      | 0xffffffff i+107, i+107, i+107, i+107, i+107, i+107
L108:
    BOOL_RUN
      | 0x50505050 f:#t0, i:X1.X, i+89, i+88, i:X1.X, i:X1.X
    COND_JUMP f:#t0, L127
    BOOL_RUN
      | 0xffffffff i+106, i+106, i+106, i+106, i+106, i+106
L127:
    BOOL_RUN
      | 0xf2f2f2f2 i:X1.X, i:X1.X, i+89, i+88, i:X1.X, i:X1.X
    COND_JUMP i+88, L141
    MOVE_64 i+80, i+112
L141:
    BOOL_RUN
      | 0x00000000 i+88, i+88, i+88, i+88, i+88, i+88
      | 0x00000000 i+89, i+89, i+89, i+89, i+89, i+89
  debug 156 file 0 line 39 column 13 id 5 kind 15
L156:
    BOOL_RUN
      | 0xeeeeeeee f:#t0, i+104, i+105, i+104, i+104, i+104
    COND_JUMP f:#t0, L215
    BOOL_RUN
      | 0x50505050 f:#t0, i:E.X, i+105, i+104, i:E.X, i:E.X
    COND_JUMP f:#t0, L186
    BOOL_RUN
      | 0xffffffff i+108, i+108, i+108, i+108, i+108, i+108
L186:
    BOOL_RUN
      | 0xf2f2f2f2 i:E.X, i:E.X, i+105, i+104, i:E.X, i:E.X
    COND_JUMP i+104, L200
    MOVE_64 i+96, i+112
L200:
    BOOL_RUN
      | 0x00000000 i+104, i+104, i+104, i+104, i+104, i+104
      | 0x00000000 i+105, i+105, i+105, i+105, i+105, i+105
  debug 215 file 0 line 33 column 13 id 1 kind 15
L215:
    COND_JUMP i:I.X, L222
    SUB_64 i:I.T, i+112, i+64
  debug 222 file 0 line 36 column 13 id 3 kind 15
L222:
    COND_JUMP i:X1.X, L229
    SUB_64 i:X1.T, i+112, i+80
  debug 229 file 0 line 39 column 13 id 5 kind 15
L229:
    COND_JUMP i:E.X, L236
    SUB_64 i:E.T, i+112, i+96
  debug 236 file 0 line 36 column 13 id 3 kind 15
L236:
    COND_JUMP i+107, L250
    BOOL_RUN
      | 0x00000000 i+107, i+107, i+107, i+107, i+107, i+107
    CALL_POU p0, i:go  ; "Logic.Leave"
L250:
    COND_JUMP i+106, L264
    BOOL_RUN
      | 0x00000000 i+106, i+106, i+106, i+106, i+106, i+106
    CALL_POU p1, i:go  ; "Logic.Enter"
  debug 264 file 0 line 39 column 13 id 5 kind 15
L264:
    COND_JUMP i+108, L278
    BOOL_RUN
      | 0x00000000 i+108, i+108, i+108, i+108, i+108, i+108
    CALL_POU p2, i:go  ; "Logic.Look"
  debug 278 file 0 line 36 column 13 id 3 kind 15
L278:
    COND_JUMP i:X1.X, L284
    CALL_POU p3, i:go  ; "Logic.Main1"
  debug 284 file 0 line 31 column 9 id -1 kind 0
L284:
    COND_JUMP i:I.X, L311
  debug 287 file 0 line 35 column 13 id 2 kind 16
    BOOL_RUN
      | 0xffffffff i+73, i+73, i+73, i+73, i+73, i+73
      | 0xffffffff i+88, i+88, i+88, i+88, i+88, i+88
      | 0xffffffff i+110, i+110, i+110, i+110, i+110, i+110
    JUMP L311
L311:
    COND_JUMP i:X1.X, L341
  debug 314 file 0 line 38 column 13 id 4 kind 16
    COND_JUMP i:go, L341
    BOOL_RUN
      | 0xffffffff i+89, i+89, i+89, i+89, i+89, i+89
      | 0xffffffff i+104, i+104, i+104, i+104, i+104, i+104
      | 0xffffffff i+110, i+110, i+110, i+110, i+110, i+110
    JUMP L341
L341:
    RETURN
pou "cyclic" task instance t13 frame t12
  debug 0 file 0 line 50 column 13 id -1 kind 19
    CALL_POU p4, i:main  ; "Logic"
  debug 3 file 0 line 49 column 11 id -1 kind 18
    RETURN
task "cyclic" period 10000000 priority 0 single "" body p5
