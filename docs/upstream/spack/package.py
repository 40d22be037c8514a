# A draft of a package of Spack: only its syntax was checked (python3 -m py_compile), not an installation by Spack.
from spack.package import *


class Mfs(CMakePackage, CudaPackage):
    """MFS, a multifrontal direct solver for large, sparse, unsymmetric linear systems, with a checked backward error."""

    homepage = "https://mfs-solver.invalid"
    git = "https://mfs-solver.invalid/mfs.git"

    license("BSD-3-Clause")

    version("main", branch="main")

    variant("trilinos", default=False, description="Build the adapter to Amesos2, and mfs-dae")
    variant("petsc", default=False, description="Build the plug-in for PETSc")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("kokkos@3.4:5+openmp+serial cxxstd=17")
    depends_on("kokkos+cuda+cuda_lambda", when="+cuda")
    depends_on("openblas@0.3.21:")
    depends_on("suite-sparse")
    depends_on("zlib-api")
    depends_on("cli11@2.1:")
    depends_on("fmt@9.1:")
    depends_on("nlohmann-json@3.11:")
    depends_on("trilinos@13.2:+amesos2+tpetra", when="+trilinos")
    depends_on("eigen@3.4:", when="+trilinos")
    depends_on("petsc@3.18:", when="+petsc")
    depends_on("mpi", when="+petsc")

    # The source of METIS 5.1.0 is compiled into libmfs with other names.
    resource(
        name="pymetis",
        url="https://files.pythonhosted.org/packages/source/P/PyMetis/PyMetis-2020.1.tar.gz",
        sha256="d13e262e8ee20963e898c2c473b69502661a8727904a49b33689fb4d42248555",
        placement="pymetis",
    )

    def cmake_args(self):
        return [
            self.define("MFS_METIS_SOURCE", join_path(self.stage.source_path, "pymetis", "src", "metis")),
            self.define("MFS_TESTS", self.run_tests),
            self.define("MFS_PERF", False),
            self.define("MFS_PYTHON", False),
            self.define_from_variant("MFS_TRILINOS", "trilinos"),
            self.define_from_variant("MFS_PETSC", "petsc"),
            self.define_from_variant("MFS_CUDA", "cuda"),
        ]
