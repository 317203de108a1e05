#include "input/bindings.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace input {

namespace {

TEST(Bindings, EveryProfileCanGoAndPointAndSaysEachThingOnce) {
    ASSERT_EQ(profiles().size(), 6u);
    for (const Profile& profile : profiles()) {
        std::set<Act> acts;
        std::set<std::string> paths;
        for (const Binding& binding : profile.bindings) {
            acts.insert(binding.act);
            const std::string path = binding.path;
            EXPECT_TRUE(path.starts_with("/user/hand/left/input/") || path.starts_with("/user/hand/right/input/"))
                << path;
            EXPECT_TRUE(paths.insert(path).second) << profile.title << ": " << path << " would say two things";
            EXPECT_EQ(kindOf(binding.act) == ActKind::pose, path.ends_with("/pose")) << path;
        }
        for (const Act needed : {Act::aim, Act::grip, Act::teleport, Act::pick})
            EXPECT_TRUE(acts.contains(needed)) << profile.title << " cannot " << nameOf(needed);
    }
}

TEST(Bindings, NamesAreWhatOpenXrTakes) {
    std::set<std::string> names;
    for (int i = 0; i < kActs; ++i) {
        const std::string name = nameOf(static_cast<Act>(i));
        EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_."), std::string::npos) << name;
        EXPECT_TRUE(names.insert(name).second) << name;
        EXPECT_FALSE(std::string(titleOf(static_cast<Act>(i))).empty());
    }
}

} // namespace

} // namespace input
