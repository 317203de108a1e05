#pragma once
// Poses as our files have them.

#include "scene/pose.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace app {

/// 16 numbers, row by row.
inline scene::Pose poseOf(const nlohmann::json& rows) {
    glm::dmat4 matrix(1);
    for (int i = 0; i < 16; ++i)
        matrix[i % 4][i / 4] = rows.at(static_cast<std::size_t>(i)).get<double>();
    scene::Pose pose;
    EXPECT_TRUE(poseFromMatrix(matrix, 1e-6, pose));
    return pose;
}

} // namespace app
