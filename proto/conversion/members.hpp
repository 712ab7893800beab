#pragma once

// COPEPOD_MEMBERS(visit, object, a, b) is visit("a", object.a); visit("b", object.b); for up to 64 members, each of
// which is named once: C++20 has no reflection. A macro may not name itself; COPEPOD_NEXT hides that until it is read
// again. NOLINTBEGIN(cppcoreguidelines-macro-usage)
#define COPEPOD_MEMBERS(visit, object, ...) COPEPOD_READ_64(COPEPOD_MEMBER(visit, object, __VA_ARGS__))
#define COPEPOD_MEMBER(visit, object, member, ...) \
  visit(#member, object.member);                   \
  __VA_OPT__(COPEPOD_NEXT COPEPOD_NONE(visit, object, __VA_ARGS__))
#define COPEPOD_NEXT() COPEPOD_MEMBER
#define COPEPOD_NONE ()
#define COPEPOD_READ_64(...) COPEPOD_READ_16(COPEPOD_READ_16(COPEPOD_READ_16(COPEPOD_READ_16(__VA_ARGS__))))
#define COPEPOD_READ_16(...) COPEPOD_READ_4(COPEPOD_READ_4(COPEPOD_READ_4(COPEPOD_READ_4(__VA_ARGS__))))
#define COPEPOD_READ_4(...) COPEPOD_READ(COPEPOD_READ(COPEPOD_READ(COPEPOD_READ(__VA_ARGS__))))
#define COPEPOD_READ(...) __VA_ARGS__
// NOLINTEND(cppcoreguidelines-macro-usage)
