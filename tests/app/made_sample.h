#pragma once
// Sample captures, each made once for all tests.

#include "tests/app/program.h"

namespace app {

/// What `make_sample ARGUMENTS` would do; arguments[0] is the folder that it makes. The sample is kept beside the built
/// programs and copied from there as long as make_sample stays what it is: most of the time goes to its light, which is
/// the same in every test.
Outcome makeSample(const std::vector<std::string>& arguments, const std::filesystem::path& scratch);

} // namespace app
