! Three spheres on two rods that learn no more than this: the four half strokes of Najafi and Golestanian, in a row.
!
!   gfortran examples/fortran/steer.f90 -Lbuild/bin -Wl,-rpath,build/bin -lcopepod -o steer
!   ./steer configs/examples/prescribed_stroke.yaml
!
! The module declares what the program calls of in_process/copepod.h, which is the reference.
module copepod
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none

  type, bind(c) :: copepod_state
    integer(c_int64_t) :: step, bodies
    type(c_ptr) :: position_m, orientation_wxyz, velocity_m_per_s, angular_velocity_rad_per_s, force_n, torque_n_m
  end type

  interface
    integer(c_int) function copepod_open(case_file, settings, directory, simulation) bind(c)
      import
      character(kind=c_char), intent(in) :: case_file(*)
      type(c_ptr), value :: settings, directory
      integer(c_int64_t), intent(out) :: simulation
    end function
    integer(c_int) function copepod_step(simulation, steps, limit_s, done) bind(c)
      import
      integer(c_int64_t), value :: simulation, steps
      real(c_double), value :: limit_s
      type(c_ptr), value :: done
    end function
    integer(c_int) function copepod_observe(simulation, state) bind(c)
      import
      integer(c_int64_t), value :: simulation
      type(copepod_state), intent(out) :: state
    end function
    integer(c_int) function copepod_act(simulation, actuator, value, steps) bind(c)
      import
      integer(c_int64_t), value :: simulation, actuator, steps
      real(c_double), value :: value
    end function
    integer(c_int) function copepod_close(simulation) bind(c)
      import
      integer(c_int64_t), value :: simulation
    end function
    type(c_ptr) function copepod_error() bind(c)
      import
    end function
    integer(c_size_t) function strlen(text) bind(c)
      import
      type(c_ptr), value :: text
    end function
  end interface

contains

  !> Ends the program with the message and the code of a call that failed.
  subroutine require(code)
    integer(c_int), intent(in) :: code
    character(kind=c_char), pointer :: message(:)
    if (code == 0) return
    call c_f_pointer(copepod_error(), message, [strlen(copepod_error())])
    write (error_unit, "(*(a))") message
    stop code, quiet=.true.
  end subroutine
end module

program steer
  use copepod
  implicit none
  integer(c_int64_t), parameter :: steps = 2500  ! of one half stroke
  real(c_double), parameter :: stroke = 16e-6_c_double  ! m
  real(c_double), parameter :: rods_m(2, 4) = reshape([-stroke, 0d0, -stroke, -stroke, 0d0, -stroke, 0d0, 0d0], [2, 4])
  character(len=4096) :: case_file
  integer(c_int64_t) :: simulation
  integer :: cycle_number, part, rod
  real(c_double) :: before_m

  call get_command_argument(1, case_file)
  call require(copepod_open(trim(case_file) // c_null_char, c_null_ptr, c_null_ptr, simulation))
  do cycle_number = 0, 1
    before_m = middle_m()
    do part = 1, 4
      do rod = 1, 2
        call require(copepod_act(simulation, int(rod - 1, c_int64_t), rods_m(rod, part), steps))
      end do
      call require(copepod_step(simulation, steps, 0d0, c_null_ptr))
    end do
    print '(a, i0, a, sp, f0.4, a)', 'cycle ', cycle_number, ': ', 1e6_c_double * (middle_m() - before_m), ' um'
  end do
  call require(copepod_close(simulation))

contains

  real(c_double) function middle_m()
    type(copepod_state) :: now
    real(c_double), pointer :: position_m(:, :)
    call require(copepod_observe(simulation, now))
    call c_f_pointer(now%position_m, position_m, [3_c_int64_t, now%bodies])
    middle_m = sum(position_m(3, :)) / real(now%bodies, c_double)
  end function
end program
