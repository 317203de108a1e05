#include "scene/overlap.h"

#include "tests/scene/known_scenes.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace scene {
namespace {

std::vector<std::vector<Partner>> partnersByOverlap(const std::vector<DepthImage>& images, float minShare = 0.02f) {
    std::vector<ImageOutline> outlines;
    for (const DepthImage& image : images)
        outlines.push_back(outlineOf(image));
    return findPartners(outlines, minShare);
}

const Partner* find(const std::vector<Partner>& partners, std::size_t image) {
    const auto found =
        std::find_if(partners.begin(), partners.end(), [&](const Partner& p) { return p.image == image; });
    return found == partners.end() ? nullptr : &*found;
}

/// The share of a's samples that b sees, asked of the scene itself.
double trueShare(const DepthImage& a, const DepthImage& b) {
    int seen = 0, all = 0;
    for (int y = 2; y < a.camera.height; y += 4)
        for (int x = 2; x < a.camera.width; x += 4, ++all) {
            const glm::dvec3 p = pointInWorld(a, x + 0.5, y + 0.5, static_cast<double>(a.disparity(x, y)));
            const glm::dvec3 inB = inverse(b.worldFromCamera) * p;
            if (inB.z <= 0) continue;
            const glm::dvec2 uv = project(b.camera, inB);
            if (uv.x < 0 || uv.y < 0 || uv.x >= b.camera.width || uv.y >= b.camera.height) continue;
            const glm::dvec3 ray = p - b.worldFromCamera.translation;
            seen += castRay(bareRoom(), b.worldFromCamera.translation, ray)->distanceMetres > 0.99 * glm::length(ray);
        }
    return static_cast<double>(seen) / all;
}

TEST(Pairs, SeeTheOverlapThatIsThere) {
    const std::vector<DepthImage> images = imagesOfBareRoom(8);
    const auto partners = partnersByOverlap(images);
    int overlapping = 0;
    for (std::size_t a = 0; a < images.size(); ++a)
        for (std::size_t b = 0; b < images.size(); ++b) {
            if (a == b) continue;
            const double share = std::max(trueShare(images[a], images[b]), trueShare(images[b], images[a]));
            const Partner* found = find(partners[a], b);
            if (share > 0.1) {
                ++overlapping;
                ASSERT_TRUE(found) << a << " and " << b << " share " << share;
                // A guess from coarse outlines, with occlusion forgiven within 30 % of depth.
                EXPECT_NEAR(static_cast<double>(found->share), share, 0.3) << a << " and " << b;
            }
            EXPECT_EQ(found != nullptr, find(partners[b], a) != nullptr)
                << a << " and " << b << " are not each other's";
        }
    EXPECT_GT(overlapping, 20);
    for (const auto& list : partners) {
        EXPECT_TRUE(std::is_sorted(list.begin(), list.end(),
                                   [](const Partner& p, const Partner& q) { return p.share > q.share; }));
    }
}

TEST(Pairs, AreNotFoundBetweenRoomsFarApart) {
    std::vector<DepthImage> images = imagesOfBareRoom(4);
    for (std::size_t i = 0; i < 4; ++i) {
        images.push_back(images[i]);
        images.back().worldFromCamera.translation += glm::dvec3(5000, -3000, 0);
    }
    const auto partners = partnersByOverlap(images);
    for (std::size_t a = 0; a < 8; ++a) {
        EXPECT_FALSE(partners[a].empty()) << a;
        for (const Partner& partner : partners[a])
            EXPECT_EQ(partner.image / 4, a / 4) << "image " << a;
    }
}

TEST(Pairs, GrowLinearlyAlongACorridor) {
    // Views along a wall, each of which sees 4 m of it; 0.5 m from one to the next.
    const auto pairsOf = [](int count) {
        std::vector<DepthImage> images;
        for (int i = 0; i < count; ++i)
            images.push_back(imageOf({32, 24, 16, 16, 16, 12}, {glm::dmat3(1.0), {0.5 * i, 0, 0}},
                                     [](double, double) { return 0.5; }));
        std::size_t pairs = 0;
        for (const auto& list : partnersByOverlap(images)) {
            EXPECT_LE(list.size(), 16u);
            pairs += list.size();
        }
        return pairs;
    };
    const std::size_t fifty = pairsOf(50), twoHundred = pairsOf(200);
    EXPECT_GT(fifty, 500u);
    EXPECT_NEAR(static_cast<double>(twoHundred), 4.0 * static_cast<double>(fifty),
                0.15 * static_cast<double>(twoHundred));
}

// Bounds of a wall that is parallel to an axis have no thickness; two images of it, registered to a centimetre, must
// meet.
TEST(Pairs, AreFoundOnAFlatWallInSpiteOfRegistration) {
    std::vector<DepthImage> images;
    for (const double off : {0.0, 0.01, -0.01})
        images.push_back(
            imageOf(smallCamera(), {glm::dmat3(1.0), {10 * off, 0, off}}, [](double, double) { return 0.5; }));
    const auto partners = partnersByOverlap(images);
    for (std::size_t i = 0; i < images.size(); ++i)
        EXPECT_EQ(partners[i].size(), 2u) << "image " << i;
}

TEST(Pairs, OfEmptyAndSparseImages) {
    std::vector<DepthImage> images = imagesOfBareRoom(2);
    images.push_back(images[0]); // every fourth sample
    images.push_back(images[0]); // none
    images.push_back(imageOf({1, 1, 1, 1, 0.5, 0.5}, images[0].worldFromCamera, [](double, double) { return 0.3; }));
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            if (x % 2 || y % 2) images[2].flags(x, y) = kNoSurface;
            images[3].flags(x, y) = kNoSurface;
        }
    const auto partners = partnersByOverlap(images);
    EXPECT_TRUE(find(partners[0], 2));
    EXPECT_TRUE(partners[3].empty());
    for (const auto& list : partners)
        EXPECT_FALSE(find(list, 3));
    EXPECT_TRUE(findPartners({}).empty());
}

} // namespace
} // namespace scene
