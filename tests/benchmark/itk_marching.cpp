// SPDX-License-Identifier: Apache-2.0
// ITK's fast marching, for the benchmark's table of fronts: a program of its own, so that nothing of Photic's needs
// ITK.
//     photic_itk_marching N IN OUT
// IN holds N^3 doubles, x fastest, in cells: the arrival where it is known, and 1e60 elsewhere. OUT gets all of them.
// Prints the processor seconds of the march alone.
#include <itkFastMarchingImageFilter.h>
#include <itkImage.h>
#include <itkImageRegionIterator.h>
#include <itkMultiThreaderBase.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <vector>

int main(int argc, char** argv) {
    using Image = itk::Image<double, 3>;
    using March = itk::FastMarchingImageFilter<Image, Image>;
    if (argc != 4) return 2;
    const auto n = static_cast<std::size_t>(std::atoi(argv[1]));
    std::vector<double> arrival(n * n * n);
    std::ifstream in(argv[2], std::ios::binary);
    const auto bytes = static_cast<std::streamsize>(arrival.size() * sizeof(double));
    if (!in.read(reinterpret_cast<char*>(arrival.data()), bytes)) return 3;

    itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(1);
    const auto known = March::NodeContainer::New(), trial = March::NodeContainer::New();
    known->Initialize(), trial->Initialize();
    unsigned knowns = 0, trials = 0;
    const auto isKnown = [&](std::size_t x, std::size_t y, std::size_t z) {
        return arrival[(z * n + y) * n + x] < 1e59;
    };
    for (std::size_t z = 0; z < n; ++z)
        for (std::size_t y = 0; y < n; ++y)
            for (std::size_t x = 0; x < n; ++x) {
                if (!isKnown(x, y, z)) continue;
                March::NodeType node;
                node.SetValue(arrival[(z * n + y) * n + x]);
                node.SetIndex({{long(x), long(y), long(z)}});
                // A march begins at those of known cells that have others beside them.
                const bool rim = (x > 0 && !isKnown(x - 1, y, z)) || (x + 1 < n && !isKnown(x + 1, y, z)) ||
                                 (y > 0 && !isKnown(x, y - 1, z)) || (y + 1 < n && !isKnown(x, y + 1, z)) ||
                                 (z > 0 && !isKnown(x, y, z - 1)) || (z + 1 < n && !isKnown(x, y, z + 1));
                if (rim)
                    trial->InsertElement(trials++, node);
                else
                    known->InsertElement(knowns++, node);
            }
    const auto march = March::New();
    march->SetSpeedConstant(1.0);
    march->SetAlivePoints(known), march->SetTrialPoints(trial);
    March::OutputSizeType size;
    size.Fill(n);
    march->SetOutputSize(size);
    const std::clock_t start = std::clock();
    march->Update();
    std::printf("%.6f\n", double(std::clock() - start) / CLOCKS_PER_SEC);
    itk::ImageRegionIterator<Image> it(march->GetOutput(), march->GetOutput()->GetLargestPossibleRegion());
    for (double& value : arrival) value = it.Get(), ++it;
    std::ofstream out(argv[3], std::ios::binary);
    out.write(reinterpret_cast<const char*>(arrival.data()), bytes);
    return out.good() ? 0 : 4;
}
