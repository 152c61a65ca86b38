# svocl_inject_faults(name): routes what a test's static libraries call through faults.c, faults_cl.c and faults_gl.cpp.
enable_language(CXX)
set(SVOCL_FAULTS_CALLS
  access aligned_alloc calloc close closedir dladdr dlclose dlopen dlsym fchmod fchown fclose fcntl ferror fflush fgetc
  fopen fread free fseek fstat fsync ftruncate fwrite getrlimit kill link linkat lseek lstat malloc mkdir mmap munmap
  nanosleep
  open opendir pipe2 poll posix_memalign posix_spawn posix_spawn_file_actions_adddup2 posix_spawn_file_actions_addopen
  posix_spawn_file_actions_init posix_spawnattr_init posix_spawnattr_setflags posix_spawnattr_setsigdefault
  posix_spawnattr_setsigmask pread pwrite read readdir readlink realloc realpath rename rmdir setrlimit stat strdup
  strndup
  unlink waitpid write clBuildProgram clCreateBuffer clCreateCommandQueue clCreateContext clCreateKernel
  clCreateProgramWithBinary clCreateProgramWithSource clCreateSubBuffer clCreateSubDevices clCreateUserEvent
  clEnqueueBarrierWithWaitList clEnqueueCopyBuffer clEnqueueFillBuffer clEnqueueMapBuffer clEnqueueMarkerWithWaitList
  clEnqueueNDRangeKernel clEnqueueReadBuffer clEnqueueUnmapMemObject clEnqueueWriteBuffer clFinish clFlush
  clGetCommandQueueInfo clGetContextInfo clGetDeviceIDs clGetDeviceInfo clGetEventInfo clGetEventProfilingInfo
  clGetExtensionFunctionAddressForPlatform clGetKernelInfo clGetMemObjectInfo clGetPlatformIDs clGetPlatformInfo
  clGetProgramBuildInfo clGetProgramInfo clReleaseCommandQueue clReleaseContext clReleaseDevice clReleaseEvent
  clReleaseKernel clReleaseMemObject clReleaseProgram clRetainCommandQueue clRetainContext clRetainDevice clRetainEvent
  clRetainKernel clRetainMemObject clRetainProgram clSetEventCallback clSetKernelArg clSetMemObjectDestructorCallback
  clSetUserEventStatus clWaitForEvents)

function(svocl_inject_faults name)
  target_sources(${name} PRIVATE faults.c faults_cl.c faults_gl.cpp)
  set_source_files_properties(faults_gl.cpp PROPERTIES COMPILE_OPTIONS "-std=c++17")
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/glinterop ${PROJECT_SOURCE_DIR}/lib
                                             ${PROJECT_SOURCE_DIR}/kernels)
  list(TRANSFORM SVOCL_FAULTS_CALLS PREPEND "LINKER:--wrap=" OUTPUT_VARIABLE wraps)
  target_link_options(${name} PRIVATE ${wraps})
endfunction()

# A call that is neither wrapped nor known to need no wrapper fails this test.
add_test(NAME faults_complete
         COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/faults_complete.sh "${CMAKE_NM}" "${SVOCL_FAULTS_CALLS}"
                 $<TARGET_FILE:svocl> $<TARGET_FILE:svocl_gl> $<TARGET_FILE:svocl_io>)
set_tests_properties(faults_complete PROPERTIES LABELS unit TIMEOUT 60)
