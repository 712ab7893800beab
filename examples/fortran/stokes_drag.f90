! A fluid component whose main program is ours: Stokes drag on lonely spheres, F = -6 pi eta r v, T = -8 pi eta r^3 w.
!
!   gfortran -J/tmp examples/fortran/stokes_drag.f90 -Lbuild/bin -Wl,-rpath,build/bin -lcopepod -o /tmp/stokes_drag
!   deploy/copepod conformance --role fluid -- /tmp/stokes_drag
!   deploy/copepod run CASE.yaml --fluid /tmp/stokes_drag
!
! The module declares what the program calls of in_process/copepod_component.h, which is the reference.
module copepod_component
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none

  enum, bind(c)
    enumerator :: END, SETUP, SAVE_STATE, RESTORE_STATE, SUMMARISE, EXCHANGE, ADVANCE
  end enum

  type, bind(c) :: copepod_request
    integer(c_int32_t) :: kind, code
    integer(c_int64_t) :: step, bodies, loads, actuators
    type(c_ptr) :: text, position_m, orientation_wxyz, velocity_m_per_s, angular_velocity_rad_per_s
    type(c_ptr) :: force_n, torque_n_m, actuation, digest, next_step
  end type

  interface
    integer(c_int) function copepod_component_open(argc, argv, role, name, version, features) bind(c)
      import
      integer(c_int), value :: argc
      type(c_ptr), intent(in) :: argv(*)
      character(kind=c_char), intent(in) :: role(*), name(*), version(*), features(*)
    end function
    integer(c_int) function copepod_component_next(request) bind(c)
      import
      type(copepod_request), intent(out) :: request
    end function
    integer(c_int) function copepod_component_fail(code, message) bind(c)
      import
      integer(c_int), value :: code
      character(kind=c_char), intent(in) :: message(*)
    end function
    integer(c_int) function copepod_component_number(path, number) bind(c)
      import
      character(kind=c_char), intent(in) :: path(*)
      real(c_double), intent(out) :: number
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

  !> Starts the component with the command line of this process.
  subroutine open_component(role, name, version, features)
    character(len=*), intent(in) :: role, name, version, features
    character(kind=c_char, len=4096), allocatable, target, save :: words(:)  ! the component keeps them
    type(c_ptr), allocatable, save :: argv(:)
    integer :: i
    allocate (words(0:command_argument_count()), argv(0:command_argument_count()))
    do i = 0, command_argument_count()
      call get_command_argument(i, words(i))
      words(i) = trim(words(i)) // c_null_char
      argv(i) = c_loc(words(i))
    end do
    call require(copepod_component_open(size(argv), argv, role // c_null_char, name // c_null_char, &
                                        version // c_null_char, features // c_null_char))
  end subroutine

  function next_request() result(request)
    type(copepod_request) :: request
    call require(copepod_component_next(request))
  end function

  real(c_double) function number(path)
    character(len=*), intent(in) :: path
    call require(copepod_component_number(path // c_null_char, number))
  end function

  function text_of(pointer) result(text)
    type(c_ptr), intent(in) :: pointer
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: i
    call c_f_pointer(pointer, letters, [strlen(pointer)])
    allocate (character(len=size(letters)) :: text)
    do i = 1, size(letters)
      text(i:i) = letters(i)
    end do
  end function

  !> Ends the program with the message and the code of a call that failed.
  subroutine require(code)
    integer(c_int), intent(in) :: code
    if (code == 0) return
    write (error_unit, "(a)") text_of(copepod_error())
    stop code, quiet=.true.
  end subroutine
end module

program stokes_drag
  use copepod_component
  implicit none
  real(c_double), parameter :: pi = acos(-1d0)
  type(copepod_request) :: request
  real(c_double), allocatable :: radius_m(:)
  real(c_double) :: viscosity_pa_s
  integer(c_int64_t) :: steps = 0

  call open_component("fluid", "Stokes drag in Fortran", "1.0", "solver:external shape:sphere neglects:boundary checkpoint")
  do
    request = next_request()
    select case (request%kind)
    case (SETUP)
      call begin(int(request%bodies))
    case (EXCHANGE)
      call drag
    case (ADVANCE)
      steps = steps + 1
    case (SAVE_STATE)
      call save_to(text_of(request%text))
    case (RESTORE_STATE)
      call restore_from(text_of(request%text))
    case (SUMMARISE)
      call answer_digest
    case (END)
      stop request%code, quiet=.true.
    end select
  end do

contains

  subroutine begin(bodies)
    integer, intent(in) :: bodies
    character(len=12) :: body
    integer :: i
    viscosity_pa_s = number("/density_kg_per_m3") * number("/kinematic_viscosity_m2_per_s")
    allocate (radius_m(bodies))
    do i = 1, bodies
      write (body, "(i0)") i - 1
      radius_m(i) = number("/bodies/" // trim(body) // "/radius_m")
    end do
  end subroutine

  subroutine drag
    real(c_double), pointer :: v(:, :), w(:, :), force_n(:, :), torque_n_m(:, :)
    integer :: i
    call c_f_pointer(request%velocity_m_per_s, v, [3_c_int64_t, request%bodies])
    call c_f_pointer(request%angular_velocity_rad_per_s, w, [3_c_int64_t, request%bodies])
    call c_f_pointer(request%force_n, force_n, [3_c_int64_t, request%loads])
    call c_f_pointer(request%torque_n_m, torque_n_m, [3_c_int64_t, request%loads])
    force_n = 0
    torque_n_m = 0
    do i = 1, size(radius_m)
      force_n(:, i) = -6 * pi * viscosity_pa_s * radius_m(i) * v(:, i)
      torque_n_m(:, i) = -8 * pi * viscosity_pa_s * radius_m(i)**3 * w(:, i)
    end do
  end subroutine

  subroutine save_to(path)
    character(len=*), intent(in) :: path
    integer :: unit, problem
    open (newunit=unit, file=path, iostat=problem)
    if (problem == 0) write (unit, "(i0, a)", iostat=problem) steps, " steps."
    if (problem == 0) close (unit, iostat=problem)
    if (problem /= 0) call require(copepod_component_fail(73, path // " cannot be written (full disk, missing folder?). &
                                                              &Choose another one." // c_null_char))
  end subroutine

  subroutine restore_from(path)
    character(len=*), intent(in) :: path
    character(len=40) :: line
    integer :: unit, problem
    open (newunit=unit, file=path, status="old", action="read", iostat=problem)
    if (problem == 0) read (unit, "(a)", iostat=problem) line
    if (problem == 0 .and. index(line, " steps.") > 0) then
      read (line, *, iostat=problem) steps
    else
      problem = 1
    end if
    if (problem /= 0) call require(copepod_component_fail(73, path // " cannot be read (missing or damaged). Use another &
                                                              &checkpoint." // c_null_char))
  end subroutine

  subroutine answer_digest
    integer(c_int64_t), pointer :: digest
    call c_f_pointer(request%digest, digest)
    digest = steps
  end subroutine
end program
