#include "scene/image_store.h"

#include "scene/depth_tiff.h"
#include "scene/errors.h"
#include "tests/scene/file_size_limit.h"
#include "tests/scene/random_poses.h"
#include "tests/scene/scratch_folder.h"
#include "tests/scene/stored_images.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

namespace scene {
namespace {

const Camera kCamera{16, 12, 10, 10, 8, 6};

/// An image that is told by its colour.
DepthImage imageNumber(int number, const Camera& camera = kCamera) {
    return {std::to_string(number),
            camera,
            {},
            Image<Rgb8>(camera.width, camera.height, {static_cast<std::uint8_t>(number), 0, 0}),
            Image<float>(camera.width, camera.height, 0.5f),
            Image<std::uint8_t>(camera.width, camera.height, 0)};
}

class StoredImages : public testing::Test {
  protected:
    std::vector<StoredImage> store(int count) {
        std::vector<DepthImage> images;
        for (int i = 0; i < count; ++i)
            images.push_back(imageNumber(i));
        return writeImages(images, folder_.path());
    }

    ScratchFolder folder_;
};

TEST_F(StoredImages, StayWithinTheBudgetAndAreDroppedLeastRecentlyUsedFirst) {
    ImageStore images(store(6), 3 * bytesOf(kCamera));
    EXPECT_EQ(images.residentBytes(), 0u);
    for (const std::size_t i : {0, 1, 2, 0, 3, 4, 5, 0})
        EXPECT_EQ(images.borrow(i)->colour(0, 0).r, i);
    EXPECT_EQ(images.peakBytes(), 3 * bytesOf(kCamera));
    EXPECT_EQ(images.residentBytes(), 3 * bytesOf(kCamera));
    // 4, 5 and 0 are here: they need no files any more, the others do.
    for (int i = 0; i < 6; ++i)
        std::filesystem::remove(folder_ / (std::to_string(i) + ".tiff"));
    for (const std::size_t i : {4, 5, 0})
        EXPECT_EQ(images.borrow(i)->colour(0, 0).r, i);
    EXPECT_THROW(images.borrow(3), Failure);
}

TEST_F(StoredImages, AreRightInTheMemoryOfOthersOfTheSameSizeOrNot) {
    std::vector<StoredImage> stored = store(4);
    const Camera wide{24, 8, 10, 10, 12, 4}; // as many pixels
    for (const int i : {1, 3}) {
        stored[static_cast<std::size_t>(i)].camera = wide;
        writeDepthTiff(imageNumber(i, wide), stored[static_cast<std::size_t>(i)].file);
    }
    Image<std::uint8_t> flags(kCamera.width, kCamera.height, 7);
    stored[2].flagsFile = folder_ / "flags.tiff";
    writeFlagsTiff(flags, stored[2].flagsFile);
    ImageStore images(stored, bytesOf(kCamera));
    const float* disparities = nullptr; // where those of the last one were
    std::size_t before = 1;
    for (const std::size_t i : {0, 2, 1, 3, 0, 1, 2, 3, 2, 0}) {
        EXPECT_FALSE(images.isResident(i));
        DepthImage expected = imageNumber(static_cast<int>(i), stored[i].camera);
        if (i == 2) expected.flags = flags;
        const ImageStore::Lease lease = images.borrow(i);
        EXPECT_TRUE(images.isResident(i));
        EXPECT_EQ(lease->name, expected.name);
        EXPECT_EQ(lease->camera, expected.camera);
        EXPECT_TRUE(lease->colour == expected.colour && lease->disparity == expected.disparity &&
                    lease->flags == expected.flags)
            << i;
        if (i % 2 == before % 2) {
            EXPECT_EQ(lease->disparity.pixels().data(), disparities) << i;
        }
        disparities = lease->disparity.pixels().data(), before = i;
    }
}

TEST_F(StoredImages, ThatAreHeldAreNeverDropped) {
    ImageStore images(store(4), bytesOf(kCamera));
    const ImageStore::Lease first = images.borrow(0);
    {
        const ImageStore::Lease second = images.borrow(1), again = images.borrow(0);
        EXPECT_EQ(&*again, &*first) << "one image, lent twice";
        for (const std::size_t i : {2, 3, 2, 3})
            EXPECT_EQ(images.borrow(i)->colour(0, 0).r, i);
        EXPECT_EQ(first->colour(0, 0).r, 0);
        EXPECT_EQ(second->colour(0, 0).r, 1);
    }
    EXPECT_EQ(images.peakBytes(), 3 * bytesOf(kCamera)) << "two are held beyond the budget, one is read";
    images.borrow(2);
    EXPECT_EQ(images.residentBytes(), 2 * bytesOf(kCamera));
    EXPECT_EQ(first->colour(0, 0).r, 0);
}

/// Images that are told by their colour, from many threads that hold one each.
void expectThatManyBorrow(ImageStore& images) {
    constexpr int kThreads = 4, kTimes = 150;
    const int kImages = static_cast<int>(images.size());
    std::atomic<int> wrong = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < kThreads; ++t)
        threads.emplace_back([&, t] {
            RandomPlaces random(static_cast<unsigned>(t));
            for (int i = 0; i < kTimes; ++i) {
                const auto index = static_cast<std::size_t>(random.integerBetween(0, kImages - 1));
                const ImageStore::Lease lease = images.borrow(index);
                for (const Rgb8& c : lease->colour.pixels())
                    wrong += c.r != index;
                wrong += images.residentBytes() > kThreads * bytesOf(kCamera);
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(wrong, 0);
    EXPECT_LE(images.peakBytes(), kThreads * bytesOf(kCamera));
}

TEST_F(StoredImages, AreLentToManyThreads) {
    ImageStore images(store(7), 4 * bytesOf(kCamera)), aside(store(7), 4 * bytesOf(kCamera), folder_.path());
    expectThatManyBorrow(images);
    expectThatManyBorrow(aside);
}

TEST_F(StoredImages, ThatWereLaidAsideComeBackAsTheyWereWithoutTheirFiles) {
    RandomPlaces random(1);
    std::vector<DepthImage> before;
    for (int i = 0; i < 5; ++i) {
        before.push_back(imageNumber(i, i % 2 == 0 ? kCamera : Camera{9, 7, 5, 5, 4, 3}));
        before.back().worldFromCamera.translation.x = 0.1 * i;
        for (float& disparity : before.back().disparity.pixels())
            disparity = static_cast<float>(random.integerBetween(0, 1000)) / 512;
    }
    std::vector<StoredImage> stored = writeImages(before, folder_.path());
    before[1].flags = Image<std::uint8_t>(9, 7, kSkinUpper);
    stored[1].flagsFile = folder_ / "flags.tiff";
    writeFlagsTiff(before[1].flags, stored[1].flagsFile);
    ImageStore images(stored, bytesOf(kCamera), folder_.path());
    for (std::size_t i = 0; i < 5; ++i)
        images.borrow(i);
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
        EXPECT_EQ(entry.path().extension(), ".tiff") << "it has no name";
        if (entry.path() != stored[4].file) std::filesystem::remove(entry.path()); // which is here still
    }
    for (const std::size_t i : {0, 1, 2, 3, 4, 3, 0, 1}) {
        const ImageStore::Lease lease = images.borrow(i);
        EXPECT_EQ(lease->name, before[i].name);
        EXPECT_TRUE(lease->camera == before[i].camera);
        EXPECT_TRUE(lease->worldFromCamera == before[i].worldFromCamera);
        EXPECT_TRUE(lease->colour == before[i].colour) << i;
        EXPECT_TRUE(lease->disparity == before[i].disparity) << i;
        EXPECT_TRUE(lease->flags == before[i].flags) << i;
    }
    EXPECT_EQ(images.peakBytes(), bytesOf(kCamera));
}

TEST_F(StoredImages, AreReadFromTheirFilesWhereNoneCanBeLaidAside) {
    ImageStore images(store(3), bytesOf(kCamera), folder_ / "missing");
    for (const std::size_t i : {0, 1, 2, 1, 0})
        EXPECT_EQ(images.borrow(i)->colour(0, 0).r, i);
    ImageSpill none(folder_.path(), 0.0);
    EXPECT_FALSE(none.put(imageNumber(1)));
    ImageSpill some(folder_.path());
    const std::optional<ImageSpill::Place> first = some.put(imageNumber(1)), second = some.put(imageNumber(2));
    ASSERT_TRUE(first && second);
    const std::optional<DepthImage> back = some.get(*second, imageNumber(1, {9, 7, 5, 5, 4, 3}));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->name, "2");
    EXPECT_TRUE(back->colour == imageNumber(2).colour);
    // The disk is full amid the third: all is given back, and what lay there is not taken for what it was.
    {
        const FileSizeLimit limit(2 * bytesOf(kCamera) + 100);
        EXPECT_FALSE(some.put(imageNumber(3)));
    }
    EXPECT_FALSE(some.get(*first, {}));
    EXPECT_FALSE(some.put(imageNumber(4)));
}

TEST_F(StoredImages, WithADamagedFileThrowAndCanBeAskedForAgain) {
    std::vector<StoredImage> stored = store(2);
    const auto path = stored[1].file;
    const std::string whole = bytesOfFile(path);
    writeFile(path, whole.substr(0, whole.size() / 2));
    ImageStore images(std::move(stored), 10 * bytesOf(kCamera));
    std::atomic<int> failures = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            const std::string message = failureOf<Failure>([&] { images.borrow(1); });
            failures += message.find(path.string()) != std::string::npos;
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(failures, 4) << "everyone who asks is told";
    EXPECT_EQ(images.residentBytes(), 0u);
    EXPECT_EQ(images.borrow(0)->colour(0, 0).r, 0) << "the others are there";
    writeFile(path, whole);
    EXPECT_EQ(images.borrow(1)->colour(0, 0).r, 1) << "repaired, it is read";
    EXPECT_EQ(images.residentBytes(), 2 * bytesOf(kCamera));
}

TEST_F(StoredImages, OfAnotherSizeThanListedAreRefused) {
    std::vector<StoredImage> stored = store(1);
    writeDepthTiff(imageNumber(0, {16, 11, 10, 10, 8, 6}), stored[0].file);
    ImageStore images(stored, 10 * bytesOf(kCamera));
    const std::string message = failureOf<Failure>([&] { images.borrow(0); });
    EXPECT_NE(message.find(stored[0].file.string()), std::string::npos) << message;
    EXPECT_EQ(images.residentBytes(), 0u);
}

TEST_F(StoredImages, TakeTheirFlagsFromTheFlagsFile) {
    std::vector<StoredImage> stored = store(1);
    stored[0].flagsFile = folder_ / "flags.tiff";
    writeFlagsTiff(Image<std::uint8_t>(16, 12, kSkinUpper), stored[0].flagsFile);
    ImageStore images(stored, bytesOf(kCamera));
    EXPECT_EQ(images.borrow(0)->flags(3, 4), kSkinUpper);
    stored[0].flagsFile = folder_ / "none.tiff";
    ImageStore without(stored, bytesOf(kCamera));
    EXPECT_THROW(without.borrow(0), Failure);
}

TEST(GivenImages, AreLentAsTheyAre) {
    std::vector<DepthImage> given;
    for (int i = 0; i < 3; ++i)
        given.push_back(imageNumber(i));
    ImageStore images(std::move(given));
    EXPECT_EQ(images.size(), 3u);
    EXPECT_EQ(images.at(2).name, "2");
    EXPECT_EQ(images.borrow(1)->colour(0, 0).r, 1);
    EXPECT_EQ(images.residentBytes(), 3 * bytesOf(kCamera));
    // A lease that was moved from gives nothing back.
    std::optional<ImageStore::Lease> lease(images.borrow(0));
    const ImageStore::Lease taken(std::move(*lease));
    lease.reset();
    EXPECT_EQ(taken->colour(0, 0).r, 0);
}

/// Numbers that threads wait for each other to reach.
class Meeting {
  public:
    int come() {
        const std::lock_guard lock(mutex_);
        changed_.notify_all();
        return ++came_;
    }
    /// False: so many never came.
    bool await(int count) {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, std::chrono::seconds(20), [&] { return came_ >= count; });
    }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    int came_ = 0;
};

TEST_F(StoredImages, AreVisitedOnceEachByAsManyAtATimeAsFit) {
    if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "because there is one processor";
    for (const int together : {1, 2}) {
        const ImageStore images(store(50), static_cast<std::size_t>(together) * 3 * bytesOf(kCamera));
        std::vector<std::atomic<int>> visits(images.size());
        std::atomic<int> now = 0, most = 0;
        Meeting meeting;
        visitEach(images, 3, [&](std::size_t i) {
            const int here = ++now;
            for (int seen = most; seen < here && !most.compare_exchange_weak(seen, here);) {
            }
            meeting.come();
            EXPECT_TRUE(meeting.await(together));
            tbb::parallel_for(0, 100, [&](int k) { visits[i] += k == 50; }); // while it waits, others might be begun
            --now;
        });
        EXPECT_EQ(most, together);
        for (const std::atomic<int>& count : visits)
            EXPECT_EQ(count, 1);
    }
}

TEST_F(StoredImages, AreVisitedOneAtATimeHoweverLittleRoomThereIs) {
    int visits = 0;
    visitEach(ImageStore(store(3), 0), 1, [&](std::size_t) { ++visits; });
    visitEach(ImageStore(std::vector<StoredImage>(), 1), 1, [&](std::size_t) { ++visits; });
    EXPECT_EQ(visits, 3);
}

TEST(VisitEach, FinishesWhatIsUnderWayWholeWhereAnotherFailed) {
    if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "because there is one processor";
    Meeting meeting, failing;
    std::atomic<int> visits = 0, steps = 0;
    const auto visit = [&](std::size_t) {
        ++visits;
        const bool isFirst = meeting.come() == 1;
        EXPECT_TRUE(meeting.await(2));
        if (isFirst) {
            failing.come();
            throw Failure("is none", std::string("image"), "leave it");
        }
        EXPECT_TRUE(failing.await(1));
        // Some hundredths of a second, in which that exception comes wherever it is caught.
        tbb::parallel_for(0, 1000, [&](int) {
            std::this_thread::sleep_for(std::chrono::microseconds(50));
            ++steps;
        });
    };
    EXPECT_THROW(visitEach(1000, 2, visit), Failure);
    EXPECT_EQ(steps, 1000 * (visits - 1)) << "whole";
    EXPECT_LT(visits, 1000) << "two, or few more if the one that failed is held up";
}

} // namespace
} // namespace scene
