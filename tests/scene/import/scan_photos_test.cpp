// Which photographs of an E57 file can be used, and what is said of the others.

#include "scene/import/scan_photos.h"

#include "scene/import/importer.h"

#include "tests/scene/import/written_e57.h"

#include <array>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace scene {
namespace {

using testing::HasSubstr;

WrittenImage imageOf(const std::string& name, const std::string& representation, std::optional<WrittenPose> pose) {
    return {name,
            representation,
            pose,
            {{"imageWidth", 60},
             {"imageHeight", 40},
             {"focalLength", 0.02},
             {"pixelWidth", 0.0005},
             {"pixelHeight", 0.0005}},
            {1, 2, 3}};
}

Capture captureOf(const TemporaryFolder& folder, const std::vector<WrittenImage>& images) {
    WrittenScan scan{"station", WrittenPose{}, cartesian({1, 2, 3}, {0, 1, 0}, {0, 0, 1})};
    writeE57(folder / "site.e57", {scan}, images);
    const std::array<std::filesystem::path, 1> inputs{folder / "site.e57"};
    return openCapture(inputs);
}

TEST(ScanPhotosOfAFile, ThoseThatCannotBeUsedAreToldOfInOneSentenceEach) {
    const TemporaryFolder folder;
    WrittenImage cameraless = imageOf("flat", "pinholeRepresentation", WrittenPose{});
    cameraless.numbers[2].value = 0;
    const Capture capture =
        captureOf(folder, {imageOf("good", "pinholeRepresentation", WrittenPose{1, 0, 0, 0, 0.1, 0, 0}),
                           imageOf("ball", "sphericalRepresentation", WrittenPose{}),
                           imageOf("tin", "cylindricalRepresentation", WrittenPose{}),
                           imageOf("tin two", "cylindricalRepresentation", WrittenPose{}),
                           imageOf("card", "visualReferenceRepresentation", std::nullopt),
                           imageOf("lost", "pinholeRepresentation", std::nullopt), cameraless,
                           imageOf("far", "pinholeRepresentation", WrittenPose{1, 0, 0, 0, 20, 0, 0})});
    ASSERT_EQ(capture.scanPhotos.size(), 1u) << "the one that stands beside the scan";
    EXPECT_EQ(capture.scanPhotos[0].name, "good");
    EXPECT_THAT(capture.remarks,
                testing::ElementsAre(HasSubstr("'ball' is not used: of a kind (spherical)"),
                                     HasSubstr("2 photographs, the first 'tin', are not used: of a kind (cylindrical)"),
                                     HasSubstr("'card' is not used: of a kind (without a camera)"),
                                     HasSubstr("'lost' is not used: the file gives no pose"),
                                     HasSubstr("'flat' is not used: its focal length and pixel size make no camera"),
                                     HasSubstr("'far' is not used: no scan stands at its place")));
}

TEST(ScanPhotosOfAFile, AreHeldOutByTheNamesTheFileHas) {
    const TemporaryFolder folder;
    const Capture capture = captureOf(folder, {imageOf("hall 1", "pinholeRepresentation", WrittenPose{}),
                                               imageOf("hall 2", "pinholeRepresentation", WrittenPose{})});
    writeBytes(folder / "names.txt", "hall 2\n");
    EXPECT_THAT(findHeldOut(capture, (folder / "names.txt").string()).scanPhotos, testing::ElementsAre(1));
}

TEST(ScanPhotosOfAFile, AreNotCalledAsAnImageOfAScanIs) {
    const TemporaryFolder folder;
    std::vector<WrittenImage> images;
    for (const char* name : {"station-front", "station-front-2", "station-down-9", "station-down-10", "station-top-2"})
        images.push_back(imageOf(name, "pinholeRepresentation", WrittenPose{}));
    std::vector<std::string> names;
    for (const ScanPhoto& photo : captureOf(folder, images).scanPhotos)
        names.push_back(photo.name);
    EXPECT_THAT(names, testing::ElementsAre("station-front-10", "station-front-2-2", "station-down-9-2",
                                            "station-down-10", "station-top-2"));
}

TEST(ScanPhotosOfAFile, AFileWithoutPhotographsHasNothingToSay) {
    const TemporaryFolder folder;
    const Capture capture = captureOf(folder, {});
    EXPECT_TRUE(capture.scanPhotos.empty());
    EXPECT_TRUE(capture.remarks.empty());
}

} // namespace
} // namespace scene
