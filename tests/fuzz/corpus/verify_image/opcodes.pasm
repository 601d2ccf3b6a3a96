image 7
project "test"
product "PICARD test"
options drawing none separate wait-free auto ""
type 0 scalar BOOL
type 1 scalar SINT
type 2 scalar USINT
type 3 scalar INT
type 4 scalar UINT
type 5 scalar DINT
type 6 scalar UDINT
type 7 scalar LINT
type 8 scalar ULINT
type 9 scalar REAL
type 10 scalar LREAL
type 11 string STRING 10 align 2
type 12 string WSTRING 5 align 2
type 13 ref t3
type 14 struct size 88 align 8 name "All"
  field "bool" t0 at 0 local
  field "i8" t1 at 1 local
  field "u8" t2 at 2 local
  field "i16" t3 at 4 local
  field "u16" t4 at 6 local
  field "i32" t5 at 8 local
  field "u32" t6 at 12 local
  field "i64" t7 at 16 local
  field "u64" t8 at 24 local
  field "f32" t9 at 32 local
  field "f64" t10 at 40 local
  field "str" t11 at 48 local
  field "wstr" t12 at 62 local
  field "ref" t13 at 80 local
type 15 struct size 0 align 1 name "All#frame"
type 16 struct size 0 align 1 name "globals"
type 17 struct size 0 align 1 name "constants"
type 18 struct size 88 align 8 name "T"
  field "All0" t14 at 0 local
type 19 struct size 0 align 1 name "T#frame"
globals 16
constants 17
pou "All" program instance t14 frame t15
    MOVE_BOOL i:bool, i:bool
    MOVE_8 i:i8, i:i8
    MOVE_16 i:i16, i:i16
    MOVE_32 i:i32, i:i32
    MOVE_64 i:i64, i:i64
    MOVE_F32 i:f32, i:f32
    MOVE_F64 i:f64, i:f64
    MOVE_STR i:str, i:str
    MOVE_WSTR i:wstr, i:wstr
    CLEAR_EVENT
    ENO i:bool
    MOVE_REF i:ref, i:ref
    ADD_8 i:i8, i:i8, i:i8
    ADD_16 i:i16, i:i16, i:i16
    ADD_32 i:i32, i:i32, i:i32
    ADD_64 i:i64, i:i64, i:i64
    ADD_F32 i:f32, i:f32, i:f32
    ADD_F64 i:f64, i:f64, i:f64
    SUB_8 i:i8, i:i8, i:i8
    SUB_16 i:i16, i:i16, i:i16
    SUB_32 i:i32, i:i32, i:i32
    SUB_64 i:i64, i:i64, i:i64
    SUB_F32 i:f32, i:f32, i:f32
    SUB_F64 i:f64, i:f64, i:f64
    MUL_8 i:i8, i:i8, i:i8
    MUL_16 i:i16, i:i16, i:i16
    MUL_32 i:i32, i:i32, i:i32
    MUL_64 i:i64, i:i64, i:i64
    MUL_F32 i:f32, i:f32, i:f32
    MUL_F64 i:f64, i:f64, i:f64
    DIV_I8 i:i8, i:i8, i:i8
    DIV_U8 i:u8, i:u8, i:u8
    DIV_I16 i:i16, i:i16, i:i16
    DIV_U16 i:u16, i:u16, i:u16
    DIV_I32 i:i32, i:i32, i:i32
    DIV_U32 i:u32, i:u32, i:u32
    DIV_I64 i:i64, i:i64, i:i64
    DIV_U64 i:u64, i:u64, i:u64
    DIV_F32 i:f32, i:f32, i:f32
    DIV_F64 i:f64, i:f64, i:f64
    MOD_I8 i:i8, i:i8, i:i8
    MOD_U8 i:u8, i:u8, i:u8
    MOD_I16 i:i16, i:i16, i:i16
    MOD_U16 i:u16, i:u16, i:u16
    MOD_I32 i:i32, i:i32, i:i32
    MOD_U32 i:u32, i:u32, i:u32
    MOD_I64 i:i64, i:i64, i:i64
    MOD_U64 i:u64, i:u64, i:u64
    EQ_8 i:bool, i:i8, i:i8
    EQ_16 i:bool, i:i16, i:i16
    EQ_32 i:bool, i:i32, i:i32
    EQ_64 i:bool, i:i64, i:i64
    EQ_F32 i:bool, i:f32, i:f32
    EQ_F64 i:bool, i:f64, i:f64
    NE_8 i:bool, i:i8, i:i8
    NE_16 i:bool, i:i16, i:i16
    NE_32 i:bool, i:i32, i:i32
    NE_64 i:bool, i:i64, i:i64
    NE_F32 i:bool, i:f32, i:f32
    NE_F64 i:bool, i:f64, i:f64
    LT_I8 i:bool, i:i8, i:i8
    LT_U8 i:bool, i:u8, i:u8
    LT_I16 i:bool, i:i16, i:i16
    LT_U16 i:bool, i:u16, i:u16
    LT_I32 i:bool, i:i32, i:i32
    LT_U32 i:bool, i:u32, i:u32
    LT_I64 i:bool, i:i64, i:i64
    LT_U64 i:bool, i:u64, i:u64
    LT_F32 i:bool, i:f32, i:f32
    LT_F64 i:bool, i:f64, i:f64
    LE_I8 i:bool, i:i8, i:i8
    LE_U8 i:bool, i:u8, i:u8
    LE_I16 i:bool, i:i16, i:i16
    LE_U16 i:bool, i:u16, i:u16
    LE_I32 i:bool, i:i32, i:i32
    LE_U32 i:bool, i:u32, i:u32
    LE_I64 i:bool, i:i64, i:i64
    LE_U64 i:bool, i:u64, i:u64
    LE_F32 i:bool, i:f32, i:f32
    LE_F64 i:bool, i:f64, i:f64
    GT_I8 i:bool, i:i8, i:i8
    GT_U8 i:bool, i:u8, i:u8
    GT_I16 i:bool, i:i16, i:i16
    GT_U16 i:bool, i:u16, i:u16
    GT_I32 i:bool, i:i32, i:i32
    GT_U32 i:bool, i:u32, i:u32
    GT_I64 i:bool, i:i64, i:i64
    GT_U64 i:bool, i:u64, i:u64
    GT_F32 i:bool, i:f32, i:f32
    GT_F64 i:bool, i:f64, i:f64
    GE_I8 i:bool, i:i8, i:i8
    GE_U8 i:bool, i:u8, i:u8
    GE_I16 i:bool, i:i16, i:i16
    GE_U16 i:bool, i:u16, i:u16
    GE_I32 i:bool, i:i32, i:i32
    GE_U32 i:bool, i:u32, i:u32
    GE_I64 i:bool, i:i64, i:i64
    GE_U64 i:bool, i:u64, i:u64
    GE_F32 i:bool, i:f32, i:f32
    GE_F64 i:bool, i:f64, i:f64
    AND_8 i:i8, i:i8, i:i8
    AND_16 i:i16, i:i16, i:i16
    AND_32 i:i32, i:i32, i:i32
    AND_64 i:i64, i:i64, i:i64
    OR_8 i:i8, i:i8, i:i8
    OR_16 i:i16, i:i16, i:i16
    OR_32 i:i32, i:i32, i:i32
    OR_64 i:i64, i:i64, i:i64
    XOR_8 i:i8, i:i8, i:i8
    XOR_16 i:i16, i:i16, i:i16
    XOR_32 i:i32, i:i32, i:i32
    XOR_64 i:i64, i:i64, i:i64
    RANGE_I8 i:i8, i:i8, i:i8, i:i8
    RANGE_U8 i:u8, i:u8, i:u8, i:u8
    RANGE_I16 i:i16, i:i16, i:i16, i:i16
    RANGE_U16 i:u16, i:u16, i:u16, i:u16
    RANGE_I32 i:i32, i:i32, i:i32, i:i32
    RANGE_U32 i:u32, i:u32, i:u32, i:u32
    RANGE_I64 i:i64, i:i64, i:i64, i:i64
    RANGE_U64 i:u64, i:u64, i:u64, i:u64
    SAME_REF i:bool, i:ref, i:ref
    PTR_TO_32 i:u32, i:u64
    PTR_FROM_32 i:u64, i:u32
    RETURN
pou "T" task instance t18 frame t19
    CALL_POU p0, i:All0  ; "All"
    RETURN
task "T" period 1000000 priority 0 single "" body p1
