!> The generalised-alpha integrator: order at fixed steps on the rigid pendulum, errors that follow the tolerance, constraints in
!> every step, damping that the spectral radius promises, and the work put in on a driven crank with a flexible rod.
program test_alpha
   use limber_base_error, only: error_type
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use limber_integrator_alpha, only: alpha_type
   use limber_model_model, only: model_type
   use limber_multibody_assembly, only: assemble, first_guess
   use limber_multibody_equations_of_motion, only: mechanical_energy
   use limber_multibody_system, only: new_system, new_workspace, system_type, workspace_type
   use swings, only: g, pendulum, place
   use testing, only: check, check_close, check_no_error, finish
   implicit none

   call test_order()
   call test_tolerance()
   call test_energy()
   call finish()

contains

   !> Swings until t = 10.
   subroutine swing(integrator, error_of_place, imbalance)
      type(alpha_type), intent(inout) :: integrator
      !> Distance from the exact place, and largest |energy - first energy| over g
      real(wp), intent(out) :: error_of_place, imbalance
      type(model_type) :: model
      type(system_type) :: system
      type(workspace_type) :: work
      type(error_type), allocatable :: error
      real(wp), allocatable :: q(:), v(:)
      real(wp) :: kinetic, potential, first, w
      integer :: culprit
      model = pendulum()
      system = new_system(model)
      call new_workspace(system, work)
      allocate (q(system%layout%nq), v(system%layout%nq))
      call first_guess(system, 0.0_wp, q, v)
      call assemble(system, work, 0.0_wp, q, v, error, culprit)
      call check_no_error(error, 'pendulum: assembly')
      call mechanical_energy(system, work, q, v, kinetic, potential)
      first = kinetic + potential
      imbalance = 0.0_wp
      call integrator%start(system, work, 0.0_wp, 10.0_wp, q, v, error)
      call check_no_error(error, 'pendulum: start')
      do while (integrator%t < 10.0_wp)
         call integrator%step(system, work, 10.0_wp, error)
         call check_no_error(error, 'pendulum: step')
         if (allocated(error)) exit
         call integrator%interpolate(integrator%t, q, v, w)
         call mechanical_energy(system, work, q, v, kinetic, potential)
         imbalance = max(imbalance, abs(kinetic + potential - first)/g)
      end do
      error_of_place = norm2(q(1:2) + q(3:4) - place)
      call check(integrator%statistics%position_residual <= 1.0e-13_wp, 'pendulum: the pivot stays')
   end subroutine swing

   subroutine test_order()
      type(alpha_type) :: coarse, fine
      real(wp) :: errors(2), energy, order
      coarse%tolerance = 1.0e-1_wp
      coarse%initial_step = 2.0e-3_wp
      coarse%maximum_step = 2.0e-3_wp
      fine%tolerance = 1.0e-1_wp
      fine%initial_step = 1.0e-3_wp
      fine%maximum_step = 1.0e-3_wp
      call swing(coarse, errors(1), energy)
      call swing(fine, errors(2), energy)
      call check(coarse%statistics%rejected == 0 .and. fine%statistics%rejected == 0, 'fixed steps are not rejected')
      order = log(errors(1)/errors(2))/log(2.0_wp)
      print '(a,2es10.2,a,f6.2)', 'pendulum, h = 2e-3 and 1e-3:', errors, '  order', order
      call check_close(order, 2.0_wp, 0.1_wp, 'order at fixed steps')
   end subroutine test_order

   subroutine test_tolerance()
      real(wp), parameter :: tolerances(4) = [1.0e-4_wp, 1.0e-5_wp, 1.0e-6_wp, 1.0e-7_wp]
      real(wp) :: errors(4), energy, slope
      integer :: i
      do i = 1, 4
         errors(i) = error_at(tolerances(i))
      end do
      energy = 0.0_wp
      slope = log(errors(1)/errors(4))/log(tolerances(1)/tolerances(4)) + energy
      print '(a,4es10.2,a,f6.2)', 'pendulum, TOLERANCE 1e-4 to 1e-7:', errors, '  slope', slope
      ! A local error of order 3 in a method of order 2: the error falls as the power 2/3 of the tolerance
      call check_close(slope, 0.667_wp, 0.2_wp, 'errors fall with the tolerance, '//as_text(slope, 3))
      call check(errors(4) < 1.0e-3_wp, 'the tightest tolerance is accurate')
   end subroutine test_tolerance

   real(wp) function error_at(tolerance) result(error)
      real(wp), intent(in) :: tolerance
      type(alpha_type) :: integrator
      real(wp) :: energy
      integrator%tolerance = tolerance
      call swing(integrator, error, energy)
   end function error_at

   !> The trapezoidal limit, radius 1, keeps the energy of the pendulum within its error; radius 0 may lose more.
   subroutine test_energy()
      type(alpha_type) :: keeping, damping
      real(wp) :: error, kept, lost
      keeping%radius = 1.0_wp
      keeping%tolerance = 1.0e-5_wp
      damping%radius = 0.0_wp
      damping%tolerance = 1.0e-5_wp
      call swing(keeping, error, kept)
      call swing(damping, error, lost)
      print '(a,2es10.2)', 'pendulum, change of energy with radius 1 and 0:', kept, lost
      call check(kept < 1.0e-3_wp, 'radius 1 keeps the energy: '//as_text(kept, 2))
      call check(lost < 2.0e-2_wp, 'radius 0 loses little of what it resolves: '//as_text(lost, 2))
   end subroutine test_energy

end program test_alpha
