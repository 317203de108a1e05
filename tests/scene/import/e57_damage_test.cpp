// E57 files that lie, are cut off or were hit by a bit: each is read or refused with a Failure, and takes no
// memory that its bytes do not justify.

#include "scene/errors.h"
#include "scene/import/e57.h"
#include "tests/scene/import/written_e57.h"

#include <random>

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace scene {
namespace {

class E57Damage : public testing::Test {
  protected:
    E57Damage() {
        std::vector<double> x, y, z, row, column;
        for (int i = 0; i < 400; ++i) {
            x.push_back(2 + 0.01 * (i % 20)), y.push_back(0.1 * (i / 20)), z.push_back(0.1 * (i % 20));
            row.push_back(i % 20), column.push_back(i / 20);
        }
        WrittenScan scan{"wall", WrittenPose{}, cartesian(x, y, z)};
        scan.fields.push_back({"rowIndex", NumberType::integer, row, 0, 19});
        scan.fields.push_back({"columnIndex", NumberType::integer, column, 0, 19});
        scan.fields.push_back({"intensity", NumberType::float32, x});
        writeE57(folder_ / "good.e57", {scan});
        good_ = readBytes(folder_ / "good.e57");
    }

    // "" if everything of the file could be read, else the failure's message. Any other exception fails the
    // test.
    std::string failureOf(const std::string& bytes) {
        writeBytes(folder_ / "bad.e57", bytes);
        return failureOf(folder_ / "bad.e57");
    }
    std::string failureOf(const std::filesystem::path& path) {
        try {
            std::vector<std::string> remarks;
            for (const ScanSource& source : listE57(path, remarks)) {
                const Scan scan = readE57Scan(source);
                EXPECT_EQ(scan.colours.size(), scan.pointsInScanner.size());
            }
            for (const E57Image& image : listE57Images(path))
                readE57ImageBytes(image);
        } catch (const Failure& failure) {
            const std::string message = failure.what();
            EXPECT_EQ(message.find(path.string()), 0u) << "the message begins with the path: " << message;
            return message;
        }
        return {};
    }
    std::string failureOfXml(const std::string& from, const std::string& to) {
        return failureOf(withXml(good_, [&](const std::string& xml) { return replaced(xml, from, to); }));
    }
    void expectRefused(const std::string& message, const std::string& words) {
        EXPECT_NE(message.find(words), std::string::npos) << "'" << message << "' does not say '" << words << "'";
    }

    TemporaryFolder folder_;
    std::string good_;
};

TEST_F(E57Damage, TheUndamagedFileIsRead) {
    EXPECT_EQ(failureOf(good_), "");
    EXPECT_EQ(withChecksums(withoutChecksums(good_)), good_) << "the tests put files together as the format wants";
}

TEST_F(E57Damage, PathsThatAreNoFiles) {
    expectRefused(failureOf(folder_ / "none.e57"), "is not there");
    expectRefused(failureOf(folder_ / ""), "is not a file");
    expectRefused(failureOf(std::string()), "too short");
    expectRefused(failureOf(std::string("ASTM-E57")), "too short");
    expectRefused(failureOf(std::string(5000, 'x')), "not an E57 file");
    expectRefused(failureOf(std::string(5000, '\0')), "not an E57 file");
}

TEST_F(E57Damage, EveryTruncationIsRefused) {
    for (std::size_t length = 0; length < good_.size(); length += length < 60 ? 1 : 97)
        EXPECT_NE(failureOf(good_.substr(0, length)), "") << "cut to " << length << " bytes";
    EXPECT_NE(failureOf(good_ + std::string(1024, ' ')), "") << "and so is what hangs on behind";
}

TEST_F(E57Damage, EveryFlippedBitIsReadOrRefused) {
    std::mt19937 random(1);
    int refused = 0;
    for (int i = 0; i < 300; ++i) {
        std::string bytes = good_;
        const std::size_t bit = random() % (bytes.size() * 8);
        bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
        refused += failureOf(bytes) != "";
    }
    EXPECT_EQ(refused, 300) << "every page has its checksum";
}

TEST_F(E57Damage, FlippedBitsBehindRightChecksumsAreReadOrRefused) {
    std::mt19937 random(2);
    const std::string content = withoutChecksums(good_);
    for (int i = 0; i < 400; ++i) {
        std::string damaged = content;
        for (int flips = 0; flips <= i % 3; ++flips) {
            // Every second one hits the header or the head of the binary section, where the sizes stand.
            const std::size_t bit = random() % ((i % 2 ? damaged.size() : 160) * 8);
            damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
        }
        failureOf(withChecksums(damaged));
    }
}

TEST_F(E57Damage, CountsAreProvedAgainstTheFileBeforeMemoryIsTaken) {
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    expectRefused(failureOfXml("recordCount=\"400\"", "recordCount=\"1000000000000\""), "claims 1000000000000 points");
    expectRefused(failureOfXml("recordCount=\"400\"", "recordCount=\"9223372036854775807\""), "claims");
    expectRefused(failureOfXml("recordCount=\"400\"", "recordCount=\"-5\""), "claims -5 points");
    expectRefused(failureOfXml("recordCount=\"400\"", "recordCount=\"500\""), "500 points");
    getrusage(RUSAGE_SELF, &after);
    EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 200 * 1024) << "kilobytes";
}

TEST_F(E57Damage, ConstantCoordinatesProveNothing) {
    // Constant fields take no bits: without a limit any number of points would fit into a kilobyte.
    const auto constant = [](const char* name, std::int64_t value, std::size_t count) {
        return WrittenField{name, NumberType::integer, std::vector<double>(count, double(value)), value, value};
    };
    WrittenScan scan{"one", {}, {constant("cartesianX", 1, 3), constant("cartesianY", 2, 3)}};
    scan.fields.push_back(constant("cartesianZ", 3, 3));
    writeE57(folder_ / "none.e57", {scan});
    expectRefused(failureOf(folder_ / "none.e57"), "claims 3 points and holds no byte for them");
    scan.fields.push_back({"cartesianInvalidState", NumberType::integer, {0, 2, 0}, 0, 2});
    writeE57(folder_ / "one.e57", {scan});
    EXPECT_EQ(failureOf(folder_ / "one.e57"), "") << "three points at one place are believed";
    const std::string claim = withXml(readBytes(folder_ / "one.e57"), [](const std::string& xml) {
        return replaced(xml, "recordCount=\"3\"", "recordCount=\"1000000000000\"");
    });
    expectRefused(failureOf(claim), "claims 1000000000000 points");
    // A floor at one height is a good scan: only one of its coordinates is constant.
    scan.fields[0] = {"cartesianX", NumberType::float32, {1, 2, 3}};
    writeE57(folder_ / "floor.e57", {scan});
    EXPECT_EQ(failureOf(folder_ / "floor.e57"), "");
}

TEST_F(E57Damage, PosesThatAreNone) {
    const std::string good = "<w type=\"Float\">1.00000000000000000e+00</w>";
    for (const char* bad : {"<w type=\"Float\">nan</w>", "<w type=\"Float\">0</w>", "<w type=\"Float\"/>",
                            "<w type=\"String\">1</w>", ""})
        expectRefused(failureOfXml(good, bad), "the pose of scan 'wall'");
    expectRefused(failureOfXml("<x type=\"Float\"/>", "<x type=\"Float\">nan</x>"), "the pose of scan 'wall'");
}

TEST_F(E57Damage, XmlThatReachesOutOrNestsDeepIsRefused) {
    expectRefused(failureOfXml("<e57Root", "<!DOCTYPE a [<!ENTITY b SYSTEM \"file:///etc/hostname\">]><e57Root"),
                  "<!DOCTYPE");
    expectRefused(failureOfXml("<e57Root type", "<e57Root xsi:schemaLocation=\"a b\" type"), "schemaLocation");
    expectRefused(failureOfXml("UTF-8", "UTF-7"), "not in UTF-8");
    std::string deep, shut;
    for (int i = 0; i < 100000; ++i)
        deep += "<a type=\"Structure\">", shut += "</a>";
    expectRefused(failureOfXml("<images2D", deep + shut + "<images2D"), "nested");
    expectRefused(failureOfXml("</e57Root>", ""), "XML section");
    expectRefused(failureOfXml("</data3D>", "</data3E>"), "XML section");
    expectRefused(failureOfXml("type=\"Vector\"", "type=\"Sector\""), "XML section");
    expectRefused(failureOfXml("<prototype type=\"Structure\">", "<prototype type=\"Vector\">"), "damaged");
}

TEST_F(E57Damage, ImagesLongerThanTheFileAreRefused) {
    writeE57(folder_ / "image.e57", {}, {{"look", "visualReferenceRepresentation", {}, {}, {1, 2, 3, 4, 5, 6, 7}}});
    const std::string claim = withXml(readBytes(folder_ / "image.e57"), [](const std::string& xml) {
        return replaced(xml, "length=\"7\"", "length=\"1000000000000\"");
    });
    expectRefused(failureOf(claim), "claims 1000000000000 bytes for image 'look'");
}

} // namespace
} // namespace scene
