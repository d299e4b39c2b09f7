// How the shim says no: an exception whose text crosses the bridge as a record that
// crates/bullet/src/error.rs takes apart again into an `Error`.
#pragma once

#include <exception>
#include <initializer_list>
#include <string>
#include <string_view>

namespace itarl {

// A record is its kind's letter and its fields, each behind the ASCII unit separator.
class Refusal : public std::exception {
 public:
  Refusal(char kind, std::initializer_list<std::string_view> fields) : record_(1, kind) {
    for (std::string_view field : fields) {
      record_ += '\x1f';
      record_ += field;
    }
  }
  const char* what() const noexcept override { return record_.c_str(); }

 private:
  std::string record_;
};

// `call`: `argument` must be `expected`, got `value`.
[[noreturn]] inline void refuse_argument(std::string_view call, std::string_view argument,
                                         std::string_view expected, std::string_view value) {
  throw Refusal('A', {call, argument, expected, value});
}

// `call`: nothing has the id `value` that `argument` gives, and `why`.
[[noreturn]] inline void refuse_id(std::string_view call, std::string_view argument,
                                   std::string_view value, std::string_view why) {
  throw Refusal('U', {call, argument, value, why});
}

// The state stopped being finite in `step`: `quantity` of the body in `slot` is `value`.
[[noreturn]] inline void refuse_state(std::string_view slot, std::string_view step,
                                      std::string_view quantity, std::string_view value) {
  throw Refusal('N', {slot, step, quantity, value});
}

[[noreturn]] inline void refuse_snapshot(std::string_view why) { throw Refusal('S', {why}); }

}  // namespace itarl

// cxx calls this around every function that Rust sees as returning Result. Its own default
// catches std::exception alone, and anything else would end the process.
namespace rust::behavior {
template <typename Try, typename Fail>
static void trycatch(Try&& attempt, Fail&& fail) noexcept try {
  attempt();
} catch (const std::exception& exception) {
  fail(exception.what());
} catch (...) {
  fail("C++ threw something that is not a std::exception");
}
}  // namespace rust::behavior
