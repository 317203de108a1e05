#include "scene/import/transforms_json.h"

#include "scene/errors.h"
#include "scene/import/importer.h"
#include "tests/scene/random_poses.h"
#include "tests/scene/scratch_folder.h"

#include <cmath>

#include <glm/geometric.hpp>

#include <nlohmann/json.hpp>

namespace scene {
namespace {

using nlohmann::json;

json matrixOf(const glm::dmat4& m) {
    json rows = json::array();
    for (int row = 0; row < 4; ++row)
        rows.push_back({m[0][row], m[1][row], m[2][row], m[3][row]});
    return rows;
}

json frameNamed(const std::string& name) {
    return {{"file_path", "images/" + name + ".png"},
            {"depth_file_path", "depth/" + name + ".png"},
            {"transform_matrix", matrixOf(glm::dmat4(1.0))}};
}

json manifestOf(std::vector<json> frames) {
    return {{"w", 64},
            {"h", 48},
            {"fl_x", 50.0},
            {"fl_y", 51.0},
            {"cx", 31.0},
            {"cy", 25.0},
            {"frames", std::move(frames)}};
}

class TransformsJson : public testing::Test {
  protected:
    Capture list(const std::string& text) {
        writeFile(manifest_, text);
        Capture capture;
        listTransformsJson(manifest_, capture);
        return capture;
    }
    Capture list(const json& root) {
        makePictures(root);
        return list(root.dump());
    }
    /// Empty files, which listing does not look into, wherever the manifest names any.
    void makePictures(const json& root) {
        if (!root.is_object() || !root.contains("frames")) return;
        for (const json& frame : root.at("frames"))
            for (const char* key : {"file_path", "depth_file_path"}) {
                if (!frame.is_object() || !frame.contains(key) || !frame.at(key).is_string()) continue;
                const std::filesystem::path picture = folder_ / frame.at(key).get<std::string>();
                std::filesystem::create_directories(picture.parent_path());
                if (!std::filesystem::exists(picture)) writeFile(picture, "");
            }
    }
    void writeManifest(const json& root) {
        makePictures(root);
        writeFile(manifest_, root.dump());
    }
    void expectRefused(const json& root, const std::string& words) {
        const std::string message = failureOf<Failure>([&] { list(root); });
        EXPECT_EQ(message.find(manifest_.string()), 0u) << "'" << message << "' for " << root.dump();
        EXPECT_NE(message.find(words), std::string::npos) << "'" << message << "' does not say '" << words << "'";
    }

    ScratchFolder folder_;
    std::filesystem::path manifest_ = folder_ / "transforms.json";
};

TEST_F(TransformsJson, GivesCameraPoseAndFiles) {
    json root = manifestOf({frameNamed("a"), frameNamed("b")});
    root["k1"] = 0.1, root["p2"] = -0.2, root["depth_unit_scale_factor"] = 0.002;
    // The camera of frame b stands at (1, 2, 3), looks along +x of the world, and its up is +z.
    glm::dmat4 worldFromGl(0.0);
    worldFromGl[0] = {0, -1, 0, 0}, worldFromGl[1] = {0, 0, 1, 0}, worldFromGl[2] = {-1, 0, 0, 0},
    worldFromGl[3] = {1, 2, 3, 1};
    root["frames"][1]["transform_matrix"] = matrixOf(worldFromGl);
    const Capture capture = list(root);
    ASSERT_EQ(capture.photos.size(), 2u);
    const PhotoSource& b = capture.photos[1];
    EXPECT_EQ(b.name, "b");
    EXPECT_EQ(b.colourPath, folder_ / "images/b.png");
    EXPECT_EQ(b.depthPath, folder_ / "depth/b.png");
    EXPECT_EQ(b.camera, (Camera{64, 48, 50, 51, 31, 25}));
    EXPECT_EQ(b.distortion, (Distortion{0.1, 0, 0, -0.2, 0}));
    EXPECT_EQ(b.depthUnitMetres, 0.002);
    EXPECT_LT(glm::distance(b.worldFromCamera * glm::dvec3(0, 0, 5), glm::dvec3(6, 2, 3)), 1e-12) << "looks along +x";
    EXPECT_LT(glm::distance(b.worldFromCamera * glm::dvec3(0, 1, 0), glm::dvec3(1, 2, 2)), 1e-12) << "down is -z";
    EXPECT_LT(glm::distance(b.worldFromCamera * glm::dvec3(1, 0, 0), glm::dvec3(1, 1, 3)), 1e-12) << "right is -y";
    EXPECT_EQ(list(manifestOf({frameNamed("a")})).photos[0].depthUnitMetres, std::nullopt)
        << "what is usual in pictures of its kind, unless told otherwise";
}

TEST_F(TransformsJson, FramesMayHaveTheirOwnIntrinsics) {
    json root = manifestOf({frameNamed("a"), frameNamed("b"), frameNamed("c")});
    root["frames"][1].update({{"w", 32}, {"h", 24}, {"fl_x", 25.0}, {"cx", 16.5}, {"k2", 0.3}});
    root["frames"][2].update({{"fl_x", nullptr}, {"camera_model", "PINHOLE"}});
    const Capture capture = list(root);
    EXPECT_EQ(capture.photos[0].camera, (Camera{64, 48, 50, 51, 31, 25}));
    EXPECT_EQ(capture.photos[1].camera, (Camera{32, 24, 25, 51, 16.5, 25}));
    EXPECT_EQ(capture.photos[1].distortion, (Distortion{0, 0.3, 0, 0, 0}));
    EXPECT_EQ(capture.photos[2].camera.fx, 50);

    json angle = manifestOf({frameNamed("a")});
    for (const char* key : {"fl_x", "fl_y", "cx", "cy"})
        angle.erase(key);
    angle["camera_angle_x"] = 2 * std::atan(0.5);
    const Camera camera = list(angle).photos[0].camera;
    EXPECT_NEAR(camera.fx, 64, 1e-9);
    EXPECT_NEAR(camera.fy, 64, 1e-9);
    EXPECT_EQ(camera.cx, 32);
    EXPECT_EQ(camera.cy, 24);
}

TEST_F(TransformsJson, WhatAFrameLacksIsNamed) {
    for (const char* key : {"file_path", "depth_file_path", "transform_matrix"}) {
        json root = manifestOf({frameNamed("a"), frameNamed("b")});
        root["frames"][1].erase(key);
        if (key != std::string("depth_file_path")) {
            expectRefused(root, key);
            expectRefused(root, "frame 1");
        }
        root["frames"][1][key] = 7;
        expectRefused(root, key);
        root["frames"][1][key] = "";
        expectRefused(root, key);
    }
    for (const char* key : {"w", "h", "fl_x"}) {
        json root = manifestOf({frameNamed("a")});
        root.erase(key);
        expectRefused(root, key);
    }
    expectRefused(manifestOf({}), "lists no frames");
    expectRefused(manifestOf({json(3)}), "not an object");
    for (const json& root :
         {json(3), json::array(), json::object(), json(nullptr), json{{"frames", 3}}, json{{"frames", json::object()}}})
        expectRefused(root, "lists no frames");
}

TEST_F(TransformsJson, FramesWithoutDepthOrWithoutTheirFilesAreLeftOutAndToldOfOnce) {
    json root = manifestOf({frameNamed("a"), frameNamed("b"), frameNamed("c"), frameNamed("d"), frameNamed("e")});
    writeManifest(root);
    EXPECT_TRUE(list(root).remarks.empty());
    const auto expectLeft = [&](const std::string& names, const std::string& remark) {
        const Capture capture = list(root.dump());
        std::string left;
        for (const PhotoSource& photo : capture.photos)
            left += photo.name;
        EXPECT_EQ(left, names);
        ASSERT_EQ(capture.remarks.size(), 1u);
        EXPECT_EQ(capture.remarks[0], manifest_.string() + ": " + remark);
    };
    root["frames"][3].erase("depth_file_path");
    expectLeft("abce", "1 of 5 frames lack their picture or its depth and were left out; the first, frame 3, has no "
                       "depth_file_path.");
    root["frames"][2]["depth_file_path"] = nullptr;
    expectLeft("abe", "2 of 5 frames lack their picture or its depth and were left out; the first, frame 2, has no "
                      "depth_file_path.");
    std::filesystem::remove(folder_ / "images/b.png");
    const std::string b = (folder_ / "images/b.png").string(), a = (folder_ / "depth/a.png").string();
    expectLeft("ae", "3 of 5 frames lack their picture or its depth and were left out; the first, frame 1, names '" +
                         b + "', which is not there.");
    std::filesystem::remove(a);
    expectLeft("e", "4 of 5 frames lack their picture or its depth and were left out; the first, frame 0, names '" + a +
                        "', which is not there.");
    // Where none is left it is as if the first were all there is.
    std::filesystem::remove(folder_ / "images/e.png");
    EXPECT_EQ(failureOf<Failure>([&] { list(root.dump()); }),
              a + ": no such picture; check the path in the capture's list of frames");
    for (json& frame : root["frames"])
        frame.erase("depth_file_path");
    EXPECT_EQ(failureOf<Failure>([&] { list(root.dump()); }),
              manifest_.string() + ", frame 0: has no depth_file_path; Revisit needs colour and depth for each frame: "
                                   "export the capture with depth");
}

TEST_F(TransformsJson, NumbersThatAreNoneAreNotPassedOver) {
    const auto refuseWith = [&](const char* key, const json& value, const std::string& words) {
        json root = manifestOf({frameNamed("a")});
        root[key] = value;
        expectRefused(root, words);
    };
    for (const double side : {0.0, -1.0, 65537.0, 1e18, 1e300})
        refuseWith("w", side, "not between 1 and 65536"), refuseWith("h", side, "not between 1 and 65536");
    refuseWith("fl_x", 0.0, "not usable");
    refuseWith("fl_y", -3.0, "not usable");
    refuseWith("k1", "0.1", "k1 is not a number");
    refuseWith("cx", json::array(), "cx is not a number");
    refuseWith("depth_unit_scale_factor", 0.0, "depth_unit_scale_factor");
    refuseWith("camera_model", 5, "frame 0: camera_model is not a name but 5; correct it");
    refuseWith("camera_model", json::array(), "camera_model is not a name but []");
    refuseWith("is_fisheye", 1, "is_fisheye is not true or false but 1");
    refuseWith("camera_model", "OPENCV_FISHEYE", "OPENCV_FISHEYE is not supported");
    // A frame's own model counts, as its own numbers do.
    json root = manifestOf({frameNamed("a")});
    root["camera_model"] = "OPENCV", root["frames"][0]["camera_model"] = "OPENCV_FISHEYE";
    expectRefused(root, "OPENCV_FISHEYE is not supported");
    const std::string text = manifestOf({frameNamed("a")}).dump();
    for (const char* number : {"NaN", "1e999", "-1e999", "Infinity"}) {
        std::string bad = text;
        bad.replace(bad.find("50.0"), 4, number);
        const std::string message = failureOf<Failure>([&] { list(bad); });
        EXPECT_EQ(message.find(manifest_.string()), 0u) << number << ": '" << message << "'";
    }
}

TEST_F(TransformsJson, LensesThatAreNotReadAreRefused) {
    const json plain = manifestOf({frameNamed("a")});
    const auto with = [&](json root, const json& keys) {
        root.update(keys);
        return root;
    };
    expectRefused(with(plain, {{"is_fisheye", true}}), "camera model OPENCV of a fisheye is not supported; undistort");
    for (const char* key : {"k4", "k5", "k6"}) {
        expectRefused(with(plain, {{key, 0.01}}), std::string("camera model OPENCV with ") + key + " is not supported");
        EXPECT_EQ(list(with(plain, {{key, 0.0}, {"is_fisheye", false}})).photos.size(), 1u);
        json own = plain;
        own["frames"][0][key] = -0.01;
        expectRefused(own, std::string("with ") + key);
    }
    for (const char* model : {"SIMPLE_RADIAL", "RADIAL"}) {
        const json radial = with(plain, {{"camera_model", model}, {"k1", 0.1}, {"k2", -0.02}, {"p1", 0.0}});
        EXPECT_EQ(list(radial).photos[0].distortion, (Distortion{0.1, -0.02, 0, 0, 0})) << model;
        for (const char* key : {"p1", "p2", "k3"})
            expectRefused(with(radial, {{key, 0.001}}), std::string("camera model ") + model + " with " + key);
    }
    EXPECT_EQ(list(with(plain, {{"camera_model", nullptr}})).photos.size(), 1u);
}

TEST_F(TransformsJson, ALensThatFoldsThePictureIsRefused) {
    json root = manifestOf({frameNamed("a"), frameNamed("b")});
    root["k1"] = -0.2;
    EXPECT_EQ(list(root).photos.size(), 2u);
    // A corner is at 0.8 of the focal length: the picture turns back on itself at sqrt(1 / (3 * 2)) = 0.41 of it.
    root["frames"][1]["k1"] = -2.0;
    expectRefused(root, "frame 1: has a lens that folds the picture over itself; check the signs");
}

TEST_F(TransformsJson, APhotographThatIsListedTwiceIsTold) {
    json again = frameNamed("a");
    const auto remarksOf = [&] {
        writeManifest(manifestOf({frameNamed("a"), frameNamed("b"), again}));
        return openCapture(std::array{manifest_}).remarks;
    };
    ASSERT_EQ(remarksOf().size(), 1u);
    EXPECT_TRUE(remarksOf()[0].ends_with("a.png' is listed twice."));
    again["transform_matrix"][0][3] = 1.0;
    ASSERT_EQ(remarksOf().size(), 1u);
    EXPECT_NE(remarksOf()[0].find("from two places: one of them is wrong"), std::string::npos);
    again = frameNamed("c");
    EXPECT_TRUE(remarksOf().empty());
}

TEST_F(TransformsJson, WhatNoCaptureHasIsRefused) {
    const auto refuse = [&](const json& root, const char* why) {
        writeManifest(root);
        const std::vector<std::filesystem::path> inputs{manifest_};
        const std::string failure = failureOf<Failure>([&] { openCapture(inputs); });
        EXPECT_NE(failure.find(why), std::string::npos) << failure << root;
    };
    glm::dmat4 far(1.0);
    far[3][1] = 1e30;
    json root = manifestOf({frameNamed("a")});
    root["frames"][0]["transform_matrix"] = matrixOf(far);
    refuse(root, "more than 100,000 km from the origin");
    for (const auto& [key, value] :
         {std::pair("fl_x", 1e30), {"fl_x", 1e-30}, {"fl_y", 1e6}, {"cx", 1e300}, {"cy", -1e6}}) {
        json odd = manifestOf({frameNamed("a")});
        odd[key] = value;
        refuse(odd, "none that takes pictures");
    }
}

TEST_F(TransformsJson, PosesThatAreNotRigidAreRefused) {
    const auto refuse = [&](const json& matrix, const char* what) {
        SCOPED_TRACE(what);
        json root = manifestOf({frameNamed("a")});
        root["frames"][0]["transform_matrix"] = matrix;
        expectRefused(root, "frame 0: transform_matrix is not a rigid 4x4 pose");
    };
    glm::dmat4 m(1.0);
    m[0][0] = -1;
    refuse(matrixOf(m), "mirrored");
    refuse(matrixOf(glm::dmat4(2.0)), "scaled, last row too");
    m = glm::dmat4(1.0), m[1][1] = 1.01;
    refuse(matrixOf(m), "stretched");
    m = glm::dmat4(1.0), m[1][0] = 0.01;
    refuse(matrixOf(m), "sheared");
    refuse(matrixOf(glm::dmat4(0.0)), "zero");
    m = glm::dmat4(1.0), m[0][3] = 0.1;
    refuse(matrixOf(m), "projective");
    json text = matrixOf(glm::dmat4(1.0));
    text[1][1] = "NaN";
    refuse(text, "text for a number");
    text[1][1] = nullptr;
    refuse(text, "NaN as JSON writers put it");
    json three = matrixOf(glm::dmat4(1.0));
    three.erase(3);
    refuse(three, "three rows");
    json narrow = matrixOf(glm::dmat4(1.0));
    narrow[2].erase(3);
    refuse(narrow, "three columns");
    refuse(json::array({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}), "sixteen numbers in a row");
    // Rounded to four digits is rigid enough, and made exactly so.
    RandomPlaces random(1);
    for (int i = 0; i < 50; ++i) {
        const Pose truth = random.pose(1);
        glm::dmat4 rounded = toMatrix(truth);
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row)
                rounded[column][row] = std::round(rounded[column][row] * 1e4) / 1e4;
        json root = manifestOf({frameNamed("a")});
        root["frames"][0]["transform_matrix"] = matrixOf(rounded);
        const glm::dmat3 r = list(root).photos[0].worldFromCamera.rotation;
        const glm::dmat3 gram = glm::transpose(r) * r;
        for (int column = 0; column < 3; ++column)
            EXPECT_LT(glm::distance(gram[column], glm::dmat3(1.0)[column]), 1e-12);
    }
}

TEST_F(TransformsJson, CutAnywhereIsAFailure) {
    const json root = manifestOf({frameNamed("a"), frameNamed("b")});
    makePictures(root);
    const std::string whole = root.dump(1);
    for (std::size_t length = 0; length < whole.size(); length += 3) {
        const std::string message = failureOf<Failure>([&] { list(whole.substr(0, length)); });
        EXPECT_EQ(message.find(manifest_.string()), 0u) << "cut at " << length << ": '" << message << "'";
    }
    EXPECT_EQ(list(whole).photos.size(), 2u);
    EXPECT_NE(failureOf<Failure>([&] { list(std::string(100000, '[')); }), "");
    std::filesystem::remove(manifest_);
    Capture capture;
    EXPECT_EQ(failureOf<Failure>([&] { listTransformsJson(manifest_, capture); }).find(manifest_.string()), 0u)
        << "is not there";
    std::filesystem::create_directory(manifest_);
    EXPECT_EQ(failureOf<Failure>([&] { listTransformsJson(manifest_, capture); }).find(manifest_.string()), 0u)
        << "is a folder";
}

TEST_F(TransformsJson, NamesOfACaptureAreUniqueFileNames) {
    const std::string umlauts = std::string(99, 'a') + "\xc3\xa4\xc3\xa4"; // the 100th byte is half a character
    writeManifest(manifestOf({frameNamed("x/1"), frameNamed("y/1"), frameNamed("1-2"), frameNamed("a b:c"),
                              frameNamed(".hidden"), frameNamed(umlauts), frameNamed("\xe6\x97\xa5")}));
    const std::filesystem::path inputs[] = {folder_.path()};
    std::vector<std::string> names;
    for (const PhotoSource& photo : openCapture(inputs).photos)
        names.push_back(photo.name);
    EXPECT_EQ(names, (std::vector<std::string>{"1", "1-2", "1-2-2", "a-b-c", "item.hidden", std::string(99, 'a'),
                                               "\xe6\x97\xa5"}));
    for (const std::string& name : names)
        EXPECT_NO_THROW(json(name).dump()) << "not UTF-8: " << name;
}

TEST_F(TransformsJson, HoldOutRulesChooseByCountOrByName) {
    std::vector<json> frames;
    for (int i = 0; i < 10; ++i)
        frames.push_back(frameNamed("frame" + std::to_string(i)));
    const Capture capture = list(manifestOf(frames));
    using Indices = std::vector<std::size_t>;
    const auto photosOf = [&](const std::string& rule) { return findHeldOut(capture, rule).photos; };
    EXPECT_EQ(photosOf(""), Indices{});
    EXPECT_EQ(photosOf("every:4"), (Indices{0, 4, 8}));
    EXPECT_EQ(photosOf("every:4:3"), (Indices{3, 7}));
    EXPECT_EQ(photosOf("every:1:0").size(), 10u);
    EXPECT_EQ(photosOf("every:5:10"), Indices{});
    EXPECT_EQ(photosOf("every:2147483647:9"), Indices{9});
    for (const char* rule : {"every:", "every:0", "every:0:3", "every:x", "every:-2", "every:3:", "every:3:x",
                             "every:3:-1", "every:3:1:1", "every:99999999999"})
        EXPECT_NE(failureOf<Failure>([&] { findHeldOut(capture, rule); }).find(rule), std::string::npos) << rule;
    const std::string names = (folder_ / "names.txt").string();
    writeFile(names, "frame7\r\n\nframe2  \nframe7\n");
    EXPECT_EQ(photosOf(names), (Indices{2, 7}));
    writeFile(names, "frame7\nframe11\n");
    const std::string message = failureOf<Failure>([&] { findHeldOut(capture, names); });
    EXPECT_NE(message.find(names + ", line 2"), std::string::npos) << message;
    EXPECT_NE(message.find("frame11"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& rule : {folder_.path().string(), names + ".gone"})
        EXPECT_NE(failureOf<Failure>([&] { findHeldOut(capture, rule); }).find(rule), std::string::npos) << rule;
}

TEST_F(TransformsJson, HoldOutNamesMayBeThoseOfThePicturesFiles) {
    const std::string longName(110, 'l');
    writeManifest(manifestOf({frameNamed("IMG-0001"), frameNamed("IMG 0001"), frameNamed("b.1"), frameNamed("b"),
                              frameNamed(longName + "1"), frameNamed(longName + "2"), frameNamed("c:d")}));
    const Capture capture = openCapture(std::array{manifest_});
    ASSERT_EQ(capture.photos[1].name, "IMG-0001-2");
    const auto heldOutBy = [&](const std::string& name) {
        writeFile(folder_ / "names.txt", name + "\n");
        return findHeldOut(capture, (folder_ / "names.txt").string()).photos;
    };
    using Indices = std::vector<std::size_t>;
    EXPECT_EQ(heldOutBy("IMG-0001"), Indices{0});
    EXPECT_EQ(heldOutBy("IMG-0001.png"), Indices{0});
    EXPECT_EQ(heldOutBy("IMG 0001"), Indices{1}) << "not the one whose name it would get alone";
    EXPECT_EQ(heldOutBy("IMG 0001.png"), Indices{1});
    EXPECT_EQ(heldOutBy("IMG-0001-2"), Indices{1});
    EXPECT_EQ(heldOutBy("b.1"), Indices{2}) << "what follows the dot is no extension";
    EXPECT_EQ(heldOutBy("b.1.png"), Indices{2});
    EXPECT_EQ(heldOutBy("b.png"), Indices{3});
    EXPECT_EQ(heldOutBy(longName + "2.png"), Indices{5});
    EXPECT_EQ(heldOutBy("c d"), Indices{6}) << "both become c-d";
    for (const std::string& unknown : {std::string("b.2"), std::string("IMG 0002.png"), std::string("b.jpg"), longName})
        EXPECT_NE(failureOf<Failure>([&] { heldOutBy(unknown); }).find(unknown), std::string::npos) << unknown;
}

} // namespace
} // namespace scene
