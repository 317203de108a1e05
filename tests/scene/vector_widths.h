#pragma once
// Code that Highway compiles for several vector widths, by each of them that this processor has.

#include <gtest/gtest.h>
#include <hwy/highway.h>

namespace scene {

class VectorWidths : public testing::Test {
  protected:
    void TearDown() override { choose(0); }

    /// Calls visit(name of the width).
    template <class Visit>
    static void forEach(Visit visit) {
        choose(0);
        for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
            choose(target);
            visit(hwy::TargetName(target));
        }
        choose(0);
    }

  private:
    /// 0: all vector widths again.
    static void choose(std::int64_t targets) {
        hwy::SetSupportedTargetsForTest(targets);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
};

} // namespace scene
