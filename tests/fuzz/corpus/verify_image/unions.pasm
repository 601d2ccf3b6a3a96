image 7
project "project"
product "PICARD 0.1.0"
options drawing none separate wait-free auto ""
file "tests/cases/st/unions/project.st"
type 0 struct size 0 align 1 name "#globals"
type 1 struct size 0 align 1
type 2 scalar BYTE
type 3 scalar DWORD
type 4 array t3 1 from 0 name "Value"
type 5 scalar POINTER
type 6 array t2 4 from 0
type 7 struct size 16 align 8
  field "LowByte" t2 at 0 return
  field "v" t4 at 4 input
  field "#t0" t5 at 8 hidden
type 8 scalar INT
type 9 struct size 8 align 4 name "Box"
  field "id" t8 at 0 member
  field "v" t4 at 4 member
type 10 array t9 2 from 0
type 11 scalar WORD
type 12 array t11 3 from 0 name "Frame"
type 13 string STRING 4 align 2
type 14 scalar POINTER
type 15 struct size 88 align 8 name "Test"
  field "u" t4 at 0 local
  field "first" t2 at 4 local
  field "last" t2 at 5 local
  field "low" t2 at 6 local
  field "r" t3 at 8 local
  field "begins" t4 at 12 local
  field "bits" t3 at 16 local
  field "box" t9 at 20 local
  field "boxes" t10 at 28 local
  field "third" t2 at 44 local
  field "i" t8 at 46 local
  field "f" t12 at 48 local
  field "length" t11 at 54 local
  field "text" t13 at 56 local
  field "copy" t4 at 64 local
  field "p" t14 at 72 local
  field "through" t11 at 80 local
  field "size" t8 at 82 local
  field "frame_size" t8 at 84 local
type 16 scalar POINTER
type 17 scalar POINTER
type 18 array t11 2 from 0
type 19 scalar POINTER
type 20 array t2 6 from 0
type 21 scalar POINTER
type 22 struct size 4 align 2 name "Head"
  field "kind" t2 at 0 member
  field "length" t11 at 2 member
type 23 scalar POINTER
type 24 string STRING 3 align 2
type 25 scalar POINTER
type 26 scalar REAL
type 27 struct size 56 align 8
  field "#t0" t16 at 0 hidden
  field "#t1" t5 at 8 hidden
  field "#t2" t17 at 16 hidden
  field "#t3" t19 at 24 hidden
  field "#t4" t21 at 32 hidden
  field "#t5" t23 at 40 hidden
  field "#t6" t25 at 48 hidden
type 28 struct size 88 align 8 name "Cyclic"
  field "main" t15 at 0 member
type 29 struct size 32 align 4 name "#constants"
  field "#c0" t3 at 0 member constant
  field "#c1" t2 at 4 member constant
  field "#c2" t11 at 6 member constant
  field "#c3" t2 at 8 member constant
  field "#c4" t2 at 9 member constant
  field "#c5" t2 at 10 member constant
  field "#c6" t24 at 12 member constant
  field "#c7" t2 at 20 member constant
  field "#c8" t26 at 24 member constant
  field "#c9" t8 at 28 member constant
  field "#c10" t8 at 30 member constant
globals 0
constants 29
  init #c0 = 1144201745
  init #c1 = 170
  init #c2 = 4660
  init #c3 = 7
  init #c4 = 205
  init #c5 = 171
  init #c6 = "hey"
  init #c7 = 105
  init #c8 = 2
  init #c9 = 4
  init #c10 = 6
pou "LowByte" function instance t1 frame t7
  debug 0 file 0 line 23 column 3 id -1 kind 21
    ADR_AT f:#t0, f:v, t4
    LOAD_PTR f:LowByte, f:#t0, t6, [0]
    RETURN
pou "Test" program instance t15 frame t27
  instance begins[0] = 1065353216
  instance box.v[0] = 168496141
  instance boxes[0].v[0] = 168496141
  instance boxes[1].v[0] = 168496141
  instance i = 1
  debug 0 file 0 line 45 column 3 id -1 kind 21
    ADR_AT f:#t0, i:u, t4
    STORE_PTR f:#t0, c:#c0, t3
  debug 8 file 0 line 46 column 3 id -1 kind 21
    ADR_AT f:#t1, i:u, t4
    LOAD_PTR i:first, f:#t1, t6, [0]
  debug 18 file 0 line 47 column 3 id -1 kind 21
    ADR_AT f:#t1, i:u, t4
    LOAD_PTR i:last, f:#t1, t6, [3]
  debug 28 file 0 line 48 column 3 id -1 kind 21
    ADR_AT f:#t1, i:u, t4
    STORE_PTR f:#t1, c:#c1, t6, [i:i]
  debug 38 file 0 line 49 column 3 id -1 kind 21
    ADR_AT f:#t0, i:u, t4
    LOAD_PTR i:r, f:#t0, t3
  debug 46 file 0 line 50 column 3 id -1 kind 21
    ADR_AT f:#t0, i:begins, t4
    LOAD_PTR i:bits, f:#t0, t3
  debug 54 file 0 line 51 column 3 id -1 kind 21
    ADR_AT f:#t1, i:box.v, t4
    LOAD_PTR i:third, f:#t1, t6, [2]
  debug 64 file 0 line 52 column 3 id -1 kind 21
    ADR_AT f:#t2, i:boxes, t10, [i:i], .1
    STORE_PTR f:#t2, c:#c2, t18, [1]
  debug 78 file 0 line 53 column 3 id -1 kind 21
    ADR_AT f:#t3, i:f, t12
    STORE_PTR f:#t3, c:#c3, t20, [0]
  debug 88 file 0 line 54 column 3 id -1 kind 21
    ADR_AT f:#t3, i:f, t12
    STORE_PTR f:#t3, c:#c4, t20, [2]
  debug 98 file 0 line 55 column 3 id -1 kind 21
    ADR_AT f:#t3, i:f, t12
    STORE_PTR f:#t3, c:#c5, t20, [3]
  debug 108 file 0 line 56 column 3 id -1 kind 21
    ADR_AT f:#t4, i:f, t12
    LOAD_PTR i:length, f:#t4, t22, .1
  debug 118 file 0 line 57 column 3 id -1 kind 21
    ADR_AT f:#t5, i:f, t12
    STORE_PTR f:#t5, c:#c6, t13
  debug 126 file 0 line 58 column 3 id -1 kind 21
    ADR_AT f:#t3, i:f, t12
    STORE_PTR f:#t3, c:#c7, t20, [1]
  debug 136 file 0 line 59 column 3 id -1 kind 21
    ADR_AT f:#t5, i:f, t12
    LOAD_PTR i:text, f:#t5, t13
  debug 144 file 0 line 60 column 3 id -1 kind 21
    COPY i:copy, i:u, t4
  debug 148 file 0 line 61 column 3 id -1 kind 21
    CALL_FN p0, 1=i:copy[0], 0=i:low  ; "LowByte"
  debug 154 file 0 line 62 column 3 id -1 kind 21
    ADR_AT i:p, i:copy, t4
  debug 158 file 0 line 63 column 3 id -1 kind 21
    MOVE_64 f:#t2, i:p
    LOAD_PTR i:through, f:#t2, t18, [1]
  debug 167 file 0 line 64 column 3 id -1 kind 21
    MOVE_64 f:#t6, i:p
    STORE_PTR f:#t6, c:#c8, t26
  debug 174 file 0 line 65 column 3 id -1 kind 21
    MOVE_16 i:size, c:#c9
  debug 177 file 0 line 66 column 3 id -1 kind 21
    MOVE_16 i:frame_size, c:#c10
    RETURN
pou "Cyclic" task instance t28 frame t1
  instance main.begins[0] = 1065353216
  instance main.box.v[0] = 168496141
  instance main.boxes[0].v[0] = 168496141
  instance main.boxes[1].v[0] = 168496141
  instance main.i = 1
  debug 0 file 0 line 72 column 13 id -1 kind 19
    CALL_POU p1, i:main  ; "Test"
  debug 3 file 0 line 71 column 10 id -1 kind 18
    RETURN
task "Cyclic" period 10000000 priority 1 single "" body p2
